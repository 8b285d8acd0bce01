"""One step by hand, in cells, on one rank; docs/one-step-by-hand.md goes through them."""

# %% A rubber block falls on a floor to which it sticks, 2D, in steps of DT.
import numpy as np

import pgimp
from pgimp.kernels.data.arguments import Forcing, Report
from pgimp.kernels.data.record import ACCELERATION, MASS, RECORD
from pgimp.kernels.step.g2p import grid_to_particles
from pgimp.kernels.step.momentum import WHOLE, update_momentum
from pgimp.kernels.step.p2g import particles_to_grid

DT = 5e-4
RUBBER = {"model": "neo-hookean", "young": 1.0e6, "poisson": 0.3, "density": 1000.0}
BOX = {"box": {"min": [0.5, 0.0], "max": [1.5, 1.0]}}
CASE = {
    "format": 1, "dimensions": 2, "grid": {"size": [2.0, 1.5], "cell": [0.1, 0.1]},
    "method": {"shape": "gimp", "particles-per-cell": [2, 2]}, "materials": {"rubber": RUBBER},
    "bodies": {"block": {"material": "rubber", "region": BOX, "velocity": [0.0, -1.0]}},
    "boundaries": {"y-min": "fixed"}, "gravity": [0.0, -9.81], "time": {"end": 1.0, "step": DT},
}  # fmt: skip

# %% Scene, grid, particles and their order, as a rank of the solver has them before its first step.
hand = pgimp.Simulation(CASE)
rank, scene, domain = hand.core.rank, hand.core.scene, hand.core.scene.domain
grid, population, p, ledger = rank.grid, rank.population, rank.up_to_date(), rank.ledger
setting, layers, vertices = scene.setting, np.arange(population.layers), grid.G.reshape(-1, RECORD)
faces, walls = domain.face_parameters(0.0, DT), domain.walls(0.0, DT)
loads = scene.interaction.loads.at(0.0)
forcing = Forcing(DT, domain.gravity(0.0), rank.mass_cutoff, loads, (), (), walls, False)


# %% P2G: masses (21), momenta (22) and internal forces (16) of the vertices.
def p2g():
    """Sum the particles."""
    grid.active[:] = 0
    given, runs = setting.without_materials(), np.array([[0, len(layers), 0]])
    particles_to_grid(given, grid.field, p, loads.summed(), population.ordered, runs, ())


p2g()
heavy = vertices[:, MASS] > rank.mass_cutoff
print(f"P2G: {heavy.sum()} vertices have {vertices[heavy, MASS].sum():.3f} kg")

# %% Momentum update: accelerations and velocities (14, 17), and what the floor holds.
update_momentum(domain.frame, grid.field, faces, forcing, ledger, (), WHOLE)
print(f"Momentum update: {(vertices[heavy, ACCELERATION + 1] == 0.0).sum()} vertices are held")


# %% G2P: positions (26), velocities (27), deformation gradients (29, 30), stresses; then the order.
def g2p():
    """Advance the particles."""
    order, moved = population.ordered, population.changed
    report = Report(rank.vertex_bounds, moved, np.zeros((8, 2), np.int64))
    counts = grid_to_particles(setting, grid.field, p, order, layers, forcing, report, ledger)
    assert counts[0] == 0, "particles are at fault"
    population.restore_order(moved[: counts[2]].copy(), order.rows[moved[: counts[2]]])


g2p()
print(f"G2P: the lowest particles have a stress of {p.sigma[:, 1].min():.0f} Pa")

# %% The solver's step has the same bits.
solver = pgimp.Simulation(CASE)
solver.step()
same = [np.array_equal(hand.particles[name], solver.particles[name]) for name in hand.particles]
print(f"{sum(same)} of {len(same)} fields have the solver's bits")

# %% A change: in each step particles take a twentieth of their velocities from the grid.
for _ in range(1999):
    p2g()
    update_momentum(domain.frame, grid.field, faces, forcing, ledger, (), WHOLE)
    x = p.x.copy()
    g2p()
    p.v[:] += 0.05 * ((p.x - x) / DT - p.v)
solver.step(1999)
for name, sim in (("the solver", solver), ("the change", hand)):
    now = sim.diagnostics() or {}
    left = now["kinetic-energy"] + now["strain-energy"] - now["external-work"]
    print(f"{name} leaves {left:.0f} J")
