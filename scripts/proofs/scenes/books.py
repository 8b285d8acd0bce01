"""The books of a scene: what its particles have must come from somewhere, step by step.

- Mass: that of the particles and of those that have left is constant.
- Momentum (of rings along their axis) grows by the impulses of gravity, of tractions, and of what
  faces and constraints say that they gave, less what damping took, to rounding. Gravity and
  tractions are summed here from the particles.
- External work is, to rounding, that of gravity and body forces (force times way of each particle),
  of tractions and of what absorbing faces hold (force times way of each vertex, as of the weight of
  rings), that of rigid bodies, and that of a prescribed motion (force times velocity), where there
  is at most one such motion. Faces at rest, and bodies that meet, do none: so books of what is at
  rest are closed. Not known are body forces on rings.
- Energy: kinetic and strain energy exceed those of the start and the external work by no more than
  the time integration explains: by a part of the energy that becomes smaller with the step. Not
  with `volume: initial`, whose forces are those of the strain energy at small strains only. What
  an accelerated wall or constraint makes of that is known and subtracted: particles take on its
  acceleration A at their own velocity v, but the work is booked with the wall's velocity u, so that
  m A (v - u) dt of energy comes from nothing; contact, whose heat and losses are counted, does
  likewise to what the grid cannot resolve of the particles' velocities. With `affine` likewise the
  power of forces on what particles carry of the velocity's variation: the grid moves with
  m (v + L (x_v - x)), particles get the acceleration for their m v alone, which near surfaces is
  not the same (docs/methods.md
  says how much that is; tests/kernels/test_affine.py that walls and constraints add nothing). With
  `mpm` nothing is claimed: a particle that has just entered a cell gives its far vertices a force
  and hardly any mass, and what they then do to it can make some per cent of the energy at once.
- No particle is deeper in a rigid body than a quarter of a cell, in the current configuration,
  where no wall, constraint or second rigid body holds it from the other side.
- Faces that hold every component take energy from what is at rest on them, and give none.
- Angular momentum of scenes without any load or condition is constant, but for what moving
  particles between their positions and the grid's loses.
"""

import contextlib
import math

import numpy as np
from proofs.scenes.energy import Seen
from proofs.scenes.own.by_hand import patch_forces, pulls_of_step
from proofs.scenes.own.vertex_work import VertexWork

from pgimp.errors import RunError
from pgimp.scene.wave_speeds import wave_speed
from pgimp.schema.tables import prescribed

#: Of mass times wave speed: forces on vertices that are too light to be accelerated are lost, about
#: 1e-8 of a particle's (see tests/proofs/test_wall_balance.py).
MOMENTUM = 1e-8
#: Of mass times wave speed squared.
WORK = 1e-9
#: Parts of the greatest energy and work that may come from nothing, and what a quarter of the step
#: must leave of more: an error of first order leaves a quarter, one that it does not explain all.
CREATED, LEFT = 0.03, 0.6
#: What hooke may add: its energy is that of the stress, right at small strains only, and bodies
#: here meet at a fifth of the wave speed.
RATE = 0.15
#: Part of a free rigid body's greatest energy, and work, that it may have from nothing: what second
#: order leaves of its rotation.
RIGID = 0.002
#: Of mass times speed times size.
ANGULAR = 0.02


def _passed(line):
    """Time that steps have taken up to a line, also while simulated time stood still."""
    return line["time"] + line.get("stages.settling-time", 0.0)


class Books:
    """What is known of a run on one rank.

    `wrong` has class and description of what does not hold; `created` is energy from nothing over
    the greatest, `turned` the change of the angular momentum over mass times speed times size.
    """

    def __init__(self, sim):
        self.sim, self.case = sim, sim.case
        self.D = sim.scene.dimension
        self.wrong, self.created, self.turned = [], 0.0, 0.0
        self._line = sim.diagnostics()
        self.mass = self._line["mass"]
        speeds = [wave_speed(sim.scene, body) for body in range(len(sim.scene.body_names))]
        self._scale = self.mass * max(speeds)
        self._momentum, self._work, self._lines = [(0.0, 0, "")], [(0.0, 0, "")], [self._line]
        self._accelerates = any(
            case.contact or case.rigid_bodies or any(each.varies for each in _conditions(case))
            for case in sim.cases
        )
        self._explained = [0.0]

    def run(self):
        """Take all steps, or those before one that fails, and close the books."""
        try:
            while not self.sim.finished:
                self._step()
        except RunError:
            pass
        self._close()

    def _vector(self, line, name):
        return np.array([line.get(f"{name}-{axis}", 0.0) for axis in "xyz"[: self.D]])

    def _step(self):
        sim, D = self.sim, self.D
        if sim.stage_done:
            sim.next_stage()
            self.case, self._line = sim.case, sim.diagnostics()
        rows, start, last = sim.live(), sim.time, self._line
        gravity = np.array(sim.scene.domain.gravity(start)[:D])
        by_faces = patch_forces(sim)
        ids = sim.particles.id[rows].tolist()
        before = dict(zip(ids, unwrapped(sim, rows), strict=True))
        seen, affine = Seen(), self.case.method.affine
        vertices = VertexWork(sim)
        with contextlib.ExitStack() as stack:
            weight = stack.enter_context(pulls_of_step(sim, gravity))
            stack.enter_context(vertices.step())
            if self._accelerates or affine:
                stack.enter_context(seen.step())
            sim.advance()
        on_surfaces = sim.scene.interaction.loads.surfaces.entries
        loads = vertices.force if on_surfaces else by_faces
        impulse = loads + sum(weight.values())
        gained = seen.accelerated() if self._accelerates else 0.0
        if affine:
            gained -= seen.unbalanced()
        self._explained.append(self._explained[-1] + gained)
        line = self._line = sim.diagnostics()
        self._lines.append(line)
        forces = [f"reaction.{face}" for face in self.case.boundaries]
        forces += [f"constraint.{name}" for name in self.case.constraints]
        impulse = sim.dt * impulse
        time = _passed(line) - _passed(last)
        impulse += time * sum((self._vector(line, name) for name in forces), np.zeros(D))
        gained = sum(
            self._vector(line, name) - self._vector(last, name)
            for name in ("momentum", "outflow.momentum", "removed.momentum", "damped-momentum")
        )
        for name in self.case.rigid_bodies:
            impulse -= time * self._vector(line, f"rigid.{name}.force")
        off = np.abs(gained - impulse)[self.case.axisymmetric :].max()
        text = f"step {sim.step}: gained {gained.tolist()}, impulses {impulse.tolist()}"
        self._momentum.append((off, sim.step, text))
        moves = any(hasattr(entry, "velocity") for entry in _conditions(self.case))
        # The mass of rings moves by the way of its centroid, their positions by that of the middle:
        # their weight's work is known at vertices, but for images beyond mirrors and seams.
        rings, case = self.case.axisymmetric, self.case
        images = sim.scene.domain.mirrors or any(sim.scene.domain.periodic)
        known = not (rings and case.gravity and (case.rigid_bodies or images))
        known &= not (rings and case.body_force)
        known &= not any(entry.placed for entry in self.case.constraints.values())
        if (len(forces) <= 1 or not moves) and known:
            self._check_work(line, last, before, weight, start, vertices)

    def _check_work(self, line, last, before, weight, start, vertices):
        sim = self.sim
        rows = sim.live()
        if len(rows) < len(before):  # the way of those that have left is not known
            return
        ids, x = sim.particles.id[rows].tolist(), unwrapped(sim, rows)
        if self.case.axisymmetric and self.case.gravity:
            work = vertices.weight
        else:
            work = sum(weight[i] @ (x[n] - before[i]) for n, i in enumerate(ids))
        work += vertices.loads + vertices.static
        time = _passed(line) - _passed(last)
        for kind, column in ("boundaries", "reaction"), ("constraints", "constraint"):
            for name, entry in getattr(self.case, kind).items():
                if hasattr(entry, "velocity"):  # where it has none a given force may move it
                    held, speed, _ = prescribed(entry.velocity, start, sim.time)
                    to, since = (
                        self._vector(each, f"displacement.{name}") for each in (line, last)
                    )
                    way = np.where(held[: self.D], time * np.array(speed[: self.D]), to - since)
                    work += way @ self._vector(line, f"{column}.{name}")
        for name in self.case.rigid_bodies:
            work += line[f"rigid.{name}.work"] - last[f"rigid.{name}.work"]
        done = line["external-work"] - last["external-work"]
        text = f"step {sim.step}: {done!r}, by the particles {work!r}"
        self._work.append((abs(done - work), sim.step, text))

    def _check_inside(self, every):
        """What a rigid body holds is at most a quarter of a cell inside, if nothing else holds."""
        cases = self.sim.cases
        if any(len(case.rigid_bodies) > 1 or case.constraints or case.boundaries for case in cases):
            return
        if any(body.formulation == "total-lagrangian" for body in self.case.bodies.values()):
            return
        for name in self.case.rigid_bodies:
            most = int(every[f"rigid.{name}.penetrating-particles"].max())
            if most:
                text = f"{most} in '{name}' by more than a quarter of a cell"
                self.wrong.append(("books: particles inside rigid bodies", text))

    def _close(self):
        every = {name: np.array([line[name] for line in self._lines]) for name in self._lines[0]}

        def total(name):
            gone = (every.get(f"{how}.{name}", 0.0) for how in ("outflow", "removed"))
            return every[name] + sum(gone)

        self._check_inside(every)
        for face, entry in self.case.boundaries.items():
            taken = every.get(f"wall.{face}.impact-loss", np.zeros(1))
            if not entry.approaches and (np.diff(_kept(taken)) < 0.0).any():
                self.wrong.append(("books: walls", f"{face} gives energy to what it holds"))
        off = np.abs(total("mass") - self.mass).max() / self.mass
        if off > 1e-13:
            self.wrong.append(("books: mass", f"it changes by {off:.3g} of itself"))
        off, _, text = max(self._momentum)
        if not off <= MOMENTUM * self._scale:
            part = off / self._scale
            self.wrong.append(("books: momentum", f"{part:.3g} of mass times wave speed; {text}"))
        off, _, text = max(self._work)
        if not off <= WORK * self._scale**2 / self.mass:
            self.wrong.append(("books: work", text))
        energy = total("kinetic-energy") + total("strain-energy")
        work = every["external-work"]
        largest = energy.max() + np.abs(work).max()
        if largest > 0.0:
            gained = energy - energy[0] - work - np.array(self._explained)
            gained -= every.get("stages.strain-energy", 0.0)
            for name, values in every.items():
                if name.endswith((".friction-heat", ".impact-loss", "damped-energy")) or (
                    name.startswith("radiated.")
                ):
                    gained += _kept(values)
            self.created = float(max(0.0, gained.max()) / largest)
        case = self.case
        driven = [
            b for b in case.rigid_bodies.values() if b.free and (b.free.force or b.free.spring)
        ]
        free = [n for n, b in case.rigid_bodies.items() if b.free and b not in driven]
        for name in () if case.gravity else free:
            own, done = every[f"rigid.{name}.kinetic-energy"], every[f"rigid.{name}.work"]
            most = max(own.max() + np.abs(done).max(), 1e-300)
            if (gained := float((own - own[0] + done).max()) / most) > RIGID:
                text = f"{name} gains {gained:.3g} of its energy"
                self.wrong.append(("books: free rigid body", text))
        loads = (
            "boundaries", "constraints", "tractions", "gravity", "rigid_bodies", "damping",
            "body-force", "water",
        )  # fmt: skip
        held = any(getattr(case, load) for case in self.sim.cases for load in loads)
        if not held and self.D > 1 and len(self._lines) > 1:
            speed = math.sqrt(2.0 * energy.max() / self.mass)
            size = max(case.grid.size)
            for axis in "xyz" if self.D == 3 else "z":
                L = total(f"angular-momentum-{axis}")
                change = float(np.ptp(L)) / max(self.mass * speed * size, 1e-300)
                self.turned = max(self.turned, change)
        if self.turned > ANGULAR:
            text = f"it changes by {self.turned:.3g} of mass times speed times size"
            self.wrong.append(("books: angular momentum", text))


def unwrapped(sim, rows):
    """Positions with their turns through periodic faces."""
    p, periods = sim.particles, sim.scene.domain.periods
    return p.x[rows] + p.winding[rows] * periods if periods.any() else p.x[rows]


def _conditions(case):
    return *case.boundaries.values(), *case.constraints.values()


def _kept(values):
    """Values of a column, those of a stage that does not have it as they were last; else 0."""
    found, last = np.zeros(len(values)), 0.0
    for i, value in enumerate(values):
        last = found[i] = last if np.isnan(value) else value
    return found


def check(load):
    """The books of a case that ``load(overrides)`` gives, with all that is wrong."""
    from pgimp.mpi.comm import Serial
    from pgimp.solver.simulation import Simulation

    case = load({})
    books = Books(Simulation(case, Serial()))
    books.run()
    models = {case.materials[body.material].model for body in case.bodies.values()}
    allowed = CREATED + RATE * ("hooke" in models)
    if books.created > allowed and case.method.tracked and case.method.shape != "mpm":
        step = case.time.step
        fixed = isinstance(step, float | int)
        key = "time.step" if fixed else "time.step.courant"
        finer = Books(Simulation(load({key: 0.25 * (step if fixed else case.courant)}), Serial()))
        finer.run()
        if finer.created > max(allowed, LEFT * books.created):
            text = f"{books.created:.3g} of the energy comes from nothing"
            text += f", {finer.created:.3g} with a quarter of the step"
            books.wrong.append(("books: energy" + ", affine" * case.method.affine, text))
    return books
