"""Velocities that vertices keep in the initial configuration: what lasts, and books of stages."""

import numpy as np
import pytest
from point_files import write_csv
from scenes import box, energy, field, finish, scene, start, wall
from tiers import wide

import pgimp
from pgimp.mpi.comm import Serial
from pgimp.solver.state.vertex_motion import begin_motion

pytestmark = pytest.mark.slow(120)
WIDE = pytest.mark.wide

#: Speed of waves in the soft solid.
C = float(np.sqrt(100.0 * 0.7 / (1.3 * 0.4)))


def initial(body):
    return body | {"formulation": "total-lagrangian"}


def turning(region, about, rate, velocity=None):
    """A body in the initial configuration that turns, counterclockwise about z."""
    spin = [0.0, 0.0, rate] if len(about) == 3 else rate
    motion = {"rotation": {"about": about, "rate": spin}}
    motion |= {"translation": velocity} if velocity else {}
    return initial({"material": "soft", "region": region, "velocity": motion})


@pytest.mark.parametrize(
    ("D", "shape", "turns"),
    [
        (2, "gimp", 10),
        pytest.param(2, "fuzzy-nearest", 10, marks=WIDE),
        pytest.param(3, "gimp", 3, marks=WIDE),
    ],
)
def test_spin_lasts(D, shape, turns):
    """Angular momentum to rounding and energy to a thousandth; its edge moves at 0.1 c."""
    size = {2: 6.0, 3: 3.0}[D]
    low, about = np.array([2.3, 2.6, 2.45][:D]), None
    about = (low + 0.5 * size).tolist()
    region = {"box": {"min": low.tolist(), "max": (low + size).tolist()}}
    rate = 0.1 * C / (0.5 * size * np.sqrt(2.0))
    body = turning(region, about, rate)
    sim = start(scene(D, body, cells=[10, 10, 8][:D], shape=shape, step={"courant": 0.4},
                      end=turns * 2.0 * np.pi / rate))  # fmt: skip
    first = sim.diagnostics()
    last = finish(sim).diagnostics()
    assert sim.step > 1000
    assert last["angular-momentum-z"] == pytest.approx(first["angular-momentum-z"], rel=1e-12)
    assert energy(last) == pytest.approx(energy(first), rel=1e-3)


def ringing(sim, period, periods, means=30):
    """Mean energy over the first periods and over the last ones, over that at the start.

    It swings, as velocities are half a step behind: by a tenth in the wave, whose strain is 2 %.
    """
    first, early, late = energy(sim.diagnostics()), [], []
    while not sim.finished:
        sim.advance()
        at = sim.time / period
        if at < means or at > periods - means:
            (early if at < means else late).append(energy(sim.diagnostics()) / first)
    return np.mean(early), np.mean(late)


@pytest.mark.parametrize("shape", ["gimp", pytest.param("fuzzy-nearest", marks=WIDE)])
def test_a_standing_wave_keeps_its_energy(shape):
    """A free bar of 10 cells, cut off the grid's lines, for 100 periods."""
    period, body = 10.0 / C, initial(box([2.3], [12.3]))
    solid = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}
    sim = start(scene(1, body, cells=[15], shape=shape, step={"courant": 0.3}, end=100 * period,
                      materials={"soft": solid}))  # fmt: skip
    p, rows = sim.particles, sim.live()
    p.v[rows, 0] = 0.02 * C * np.cos(2.0 * np.pi * (p.x[rows, 0] - 2.3) / 10.0)
    begin_motion(sim.rank)
    early, late = ringing(sim, period, 100)
    assert late == pytest.approx(early, rel=1e-3)


@pytest.mark.wide
def test_a_cantilever_rings_for_a_hundred_periods():
    period = 2.0 * np.pi / (3.516 * np.sqrt(110.0 / 3.0) / 4.0**2)
    sim = start(scene(2, initial(box([0.0, 2.0], [4.0, 4.0])), cells=[6, 6], end=100 * period,
                      step={"courant": 0.3}, boundaries={"x-min": "fixed"}))  # fmt: skip
    p, rows = sim.particles, sim.live()
    p.v[rows, 1] = 0.2 * (p.x[rows, 0] / 4.0) ** 2
    begin_motion(sim.rank)
    early, late = ringing(sim, period, 100)
    assert late == pytest.approx(early, rel=1e-3)


@pytest.mark.parametrize(("rate", "steps"), [(0.0, 10_000), wide(0.5, 100_000)])
def test_a_disk_for_a_hundred_thousand_steps(rate, steps):
    """Cut by the grid anywhere; at rest, where nothing may begin, and with its edge at 0.08 c."""
    region = {"ball": {"centre": [3.37, 3.21], "radius": 1.9}}
    body = turning(region, [3.37, 3.21], rate)
    sim = start(scene(2, body, cells=[7, 7], end=1e9, step={"courant": 0.6}))
    first = sim.diagnostics()
    for _ in range(steps):
        sim.advance()
    last = sim.diagnostics()
    if rate == 0.0:
        assert not field(sim, "v").any() and energy(last) == 0.0
    else:
        assert last["angular-momentum-z"] == pytest.approx(first["angular-momentum-z"], rel=1e-12)
        assert energy(last) == pytest.approx(energy(first), rel=2e-3)


def test_start_from_a_file_is_exact(tmp_path):
    """Momentum is that of the particles; a linear field is the vertices' own."""
    rng = np.random.default_rng(3)
    x = 2.0 + 4.0 * rng.random((80, 2))
    v = np.stack([0.3 - 0.4 * x[:, 1], 0.1 + 0.4 * x[:, 0]], axis=1)
    volume = rng.uniform(0.05, 0.25, 80)
    write_csv(tmp_path / "p.csv", {"position": x, "velocity": v, "volume": volume})
    region = {"points": {"file": str(tmp_path / "p.csv")}}
    sim = start(scene(2, initial({"material": "soft", "region": region}), end=0.5))
    line, m = sim.diagnostics(), field(sim, "m")
    mine = field(sim, "v")
    for d, axis in enumerate("xy"):
        assert line[f"momentum-{axis}"] == pytest.approx(m @ mine[:, d], rel=1e-12)
    last = finish(sim).diagnostics()
    for name in ("momentum-x", "momentum-y", "angular-momentum-z"):
        assert last[name] == pytest.approx(line[name], rel=1e-12)


def gains(sim, *names):
    """Greatest difference, in all steps and stages, of momenta from what is booked, by direction.

    Impulses of faces and constraints must be what the bodies gain, also as a stage begins.
    """
    off, last = 0.0, sim.diagnostics()
    while True:
        if sim.finished:
            return off
        if sim.stage_done:
            sim.next_stage()
        sim.advance()
        line = sim.diagnostics()
        for axis in "xy":
            own, gone = f"momentum-{axis}", f"removed.momentum-{axis}"
            gained = line[own] - last[own] + line.get(gone, 0.0) - last.get(gone, 0.0)
            given = sum(line.get(f"{name}-{axis}", 0.0) for name in names)
            off = max(off, abs(gained - given * (line["time"] - last["time"])))
        last = line


@pytest.mark.parametrize(
    ("shape", "edge", "first"),
    [("gimp", "ghost", "initial"), pytest.param("fuzzy-constant", "mirror", "initial", marks=WIDE),
     pytest.param("fuzzy-constant", "mirror", "current", marks=WIDE),
     ("bspline-quadratic", "mirror", "initial")],
)  # fmt: skip
def test_stages_book_what_they_change(shape, edge, first):
    """Bonded bodies fly and turn; one is gripped, let go, removed; walls and friction begin.

    The first of the three may be in the current configuration.
    """
    spin = {"rotation": {"about": [3.0, 1.0], "rate": 0.15}, "translation": [0.4, 0.8]}
    bodies = {
        "a": box([0.0, 0.0], [2.0, 2.0], spin) | {"formulation": first},
        "b": initial(box([2.0, 0.0], [4.5, 2.0], spin)),
        "c": initial(box([4.5, 0.0], [6.0, 2.0], spin)),
    }
    held = {"body": "b", "region": {"box": {"min": [3.0, 0.5], "max": [4.5, 4.0]}}}
    case = scene(
        2, bodies, cells=[8, 6], shape=shape, end=0.4, step={"courant": 0.3},
        boundaries={"y-max": "fixed"}, **({"wall": edge} if edge == "mirror" else {}),
    )  # fmt: skip
    friction = {"contact": [{"bodies": "all", "friction": 0.2}]}
    meets = shape == "gimp" or first != "initial"  # by surfaces: no wide shape
    if meets:
        case["contact"] = [{"bodies": "all", "law": "tie"}]
    case["time"]["stages"] = [
        {"name": "grip", "end": 0.8, "constraints": {"grip": held | {"velocity": [1.0, None]}}},
        {"name": "walls", "end": 1.2, "constraints": {"grip": None},
         "boundaries": {"x-min": wall(0.2, None), "y-min": "slip"}},
        {"name": "loose", "end": 1.6} | (friction if meets else {}),
        {"name": "gone", "end": 2.0, "remove": ["c"], "boundaries": {"y-min": "fixed"}},
    ]  # fmt: skip
    names = ("constraint.grip", *(f"reaction.{face}" for face in ("x-min", "y-min", "y-max")))
    assert gains(start(case), *names) < 1e-12


def test_a_run_resumes_after_a_body_has_been_removed_far_from_the_others(tmp_path):
    """Its vertices, which are no longer stored, have no motion in the checkpoint."""
    bodies = {
        "stays": initial(box([1.0, 1.0], [3.0, 3.0], [0.1, 0.2])),
        "goes": initial(box([5.0, 9.0], [7.0, 11.0], [0.3, 0.0])),
    }
    case = scene(2, bodies, cells=[8, 12], end=0.1, step=0.01)
    case["time"]["stages"] = [{"name": "gone", "end": 0.2, "remove": ["goes"]}]
    case |= {"checkpoint": {"every": {"steps": 4}, "keep": 2}, "history": {"every": {"steps": 1}}}
    whole = pgimp.run(case, Serial(), tmp_path / "run", quiet=True)
    lines = (whole.path / "history.csv").read_bytes()
    *_, last = sorted((whole.path / "checkpoints").iterdir())
    last.unlink()
    info = whole.path / "run.json"
    info.write_text(info.read_text().replace('"state": "done"', '"state": "running"'))
    pgimp.run(case, Serial(), tmp_path / "run", resume=True, quiet=True)
    assert (whole.path / "history.csv").read_bytes() == lines


@pytest.mark.parametrize("kind", ["slip", "fixed", "unilateral"])
@pytest.mark.parametrize("shape", ["fuzzy-constant", pytest.param("bspline-quadratic", marks=WIDE)])
def test_a_mirror_books_what_it_turns_round(shape, kind):
    """A block that turns on a wall, under gravity; and lands on one that lets it go."""
    motion = {"rotation": {"about": [4.0, 1.0], "rate": 0.6}, "translation": [0.3, -1.0]}
    low = 0.6 if kind == "unilateral" else 0.0
    shape = "gimp" if kind == "unilateral" else shape  # what meets a wall has weights of cells
    sim = start(scene(2, initial(box([2.0, low], [5.0, low + 2.0], motion)), cells=[8, 5],
                      shape=shape, wall="mirror", end=2.0, step={"courant": 0.3},
                      gravity=[0.2, -1.0], boundaries={"y-min": kind}))  # fmt: skip
    last, off = sim.diagnostics(), 0.0
    assert abs(last["momentum-y"] + last["mass"] * 1.0) < 2.0
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        for d, axis in enumerate("xy"):
            force = line[f"reaction.y-min-{axis}"] + line["mass"] * [0.2, -1.0][d]
            gained = line[f"momentum-{axis}"] - last[f"momentum-{axis}"]
            off = max(off, abs(gained - force * (line["time"] - last["time"])))
        last = line
    assert off < 1e-12
