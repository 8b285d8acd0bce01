"""Contact that keeps searches, selections and lists: the bits of one that makes them anew.

Small scenes of up to a hundred thousand steps, each run twice at once; see `scenes/anew.py`. Their
books are kept as well: momentum against what faces and weights give, and energy.
"""

import time

import numpy as np
from proofs.jobs import options_of
from proofs.scenes import anew

#: Steps between two lines of the history, which are compared, and lines between two comparisons of
#: all particles.
EVERY, COMPARE = 20, 50

#: Lines in a mean of the energy, as that of a step is of the first order in it.
WINDOW = 25


SOFT = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}


def case(cells, bodies, gravity=None, friction=0.3, walls="unilateral", **parts):
    """A case without an end, whose bodies are in the initial configuration if they are soft."""
    faces = {f"{axis}-{end}": {"unilateral": {"friction": 0.2}} if walls == "unilateral" else walls
             for axis in "xy" for end in ("min", "max")}  # fmt: skip
    return {
        "format": 1,
        "dimensions": 2,
        "grid": {"size": [float(n) for n in cells], "cell": [1.0, 1.0]},
        "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
        "time": {"end": 1.0e9, "step": {"courant": 0.3}},
        "materials": {"soft": SOFT},
        "bodies": bodies,
        "boundaries": faces,
        "contact": [{"bodies": "all", "friction": friction}],
        **({"gravity": gravity} if gravity else {}),
        **parts,
    }


def body(region, velocity=None, configuration="initial"):
    """A soft body."""
    entry = {"material": "soft", "region": region, "formulation": configuration}
    return entry | ({"velocity": velocity} if velocity else {})


def box(low, high, *args):
    return body({"box": {"min": low, "max": high}}, *args)


def ball(centre, radius, *args):
    return body({"ball": {"centre": centre, "radius": radius}}, *args)


def spin(about, rate, translation):
    return {"rotation": {"about": about, "rate": rate}, "translation": translation}


def blocks():
    """Two blocks bounce and slide between walls with friction."""
    bodies = {
        "left": box([1.3, 1.1], [5.3, 5.1], spin([3.3, 3.1], 0.1, [2.0, 0.7])),
        "right": box([7.2, 0.4], [10.7, 4.4], spin([8.7, 2.4], -0.1, [-1.5, 0.5])),
    }
    return case([13, 9], bodies, gravity=[0.0, -0.2])


def disk():
    """A disk rolls to and fro in a trough of two rigid slopes."""

    def slope(low, high, n):
        half = {"half-space": {"point": [8.0, 1.6], "normal": [n, 1.0]}}
        return {"intersection": [{"box": {"min": [low, 0.6], "max": [high, 6.0]}}, half]}

    bodies = {
        "disk": ball([4.5, 5.4], 2.2),
        "left": {"rigid": {}, "region": slope(0.1, 8.0, 0.3)},
        "right": {"rigid": {}, "region": slope(8.0, 15.9, -0.3)},
    }
    return case([16, 10], bodies, gravity=[0.0, -0.4], walls="slip")


def stack(size=(5.0, 2.0), offset=0.1, gravity=-0.1):
    """Three blocks rest on each other and on the floor."""
    corners = [[2.0 + offset * n, size[1] * n] for n in range(3)]
    bodies = {f"block{n}": box(low, [low[0] + size[0], low[1] + size[1]])
              for n, low in enumerate(corners)}  # fmt: skip
    return case([9, 10], bodies, gravity=[0.0, gravity])


def lean():
    """Higher blocks, the uppermost of which comes to lean on a wall."""
    return stack((4.0, 3.0), 0.3, -0.3)


def heap():
    """Disks in the current configuration come to rest on each other."""
    bodies = {}
    for n in range(7):
        centre = [1.9 + 2.9 * (n % 3) + 0.2 * (n // 3), 1.7 + 3.1 * (n // 3)]
        bodies[f"disk{n}"] = ball(centre, 1.4, [0.3 * (-1) ** n, 0.0], "current")
    return case([10, 11], bodies, gravity=[0.0, -0.3])


def thin():
    """Strips, one-cell bodies and corners in a mill: a cross that turns fast, and a stone."""
    bodies = {
        "strip": box([0.6, 8.2], [5.6, 8.8], [0.5, -0.5]),
        "post": box([9.2, 1.0], [9.7, 5.0], [-0.6, 0.3]),
        "one": box([1.1, 1.2], [2.1, 2.2], [1.0, 0.4]),
        "two": box([2.2, 1.3], [3.2, 2.3], [0.8, 0.5]),
        "three": box([1.3, 2.4], [2.3, 3.4], [1.2, -0.3]),
        "wedge": body({"intersection": [
            {"box": {"min": [7.5, 7.2], "max": [10.5, 9.8]}},
            {"half-space": {"point": [7.5, 9.8], "normal": [0.8, 1.0]}}]}, [-0.5, -0.6]),
        "mill": {"rigid": {"rotation": {"about": [6.0, 5.5], "rate": 0.9}},
                 "region": {"union": [{"box": {"min": [3.9, 5.0], "max": [8.1, 6.0]}},
                                      {"box": {"min": [5.5, 3.4], "max": [6.5, 7.6]}}]}},
    }  # fmt: skip
    return case([12, 11], bodies, gravity=[0.0, -0.3])


def impact():
    """Fast bodies that stretch by half: a bar, a ball and one-cell bodies between walls."""
    bodies = {
        "bar": box([1.0, 4.0], [6.0, 5.5], [1.6, 0.3]),
        "ball": ball([10.0, 4.6], 1.5, [-1.8, 0.0]),
        "one": box([7.2, 4.5], [8.0, 5.3], [0.0, 0.5]),
        "two": box([6.2, 1.0], [7.2, 2.0], [0.5, 1.5]),
        "plate": box([3.0, 7.0], [9.0, 7.5], [0.0, -1.2]),
    }
    return case([13, 9], bodies, friction=0.1)


#: Part of the greatest energy by which means of it may grow: 3e-3 where a block leans on a wall, in
#: 100,000 steps, less than 1e-3 elsewhere.
GAIN = 5e-3

#: Scenes by name, with their steps.
SCENES = {
    "blocks": (blocks, 100_000),
    "disk": (disk, 100_000),
    "stack": (stack, 100_000),
    "lean": (lean, 100_000),
    "heap": (heap, 100_000),
    "thin": (thin, 20_000),
    "impact": (impact, 4_000),
}


def main(words):
    """Run the scenes; print what was compared, and what drifted."""
    options = options_of(
        "kept", words, quick="a hundredth of the steps",
        scene={"help": "this one alone"},
    )  # fmt: skip
    anew.prepare()
    wrong = []
    for name, (make, steps) in SCENES.items():
        if options.scene in (None, name):
            wrong += watch(name, make(), steps // (100 if options.quick else 1))
    for line in wrong:
        print(f"wrong: {line}")
    return 1 if wrong else 0


def watch(name, case, steps):
    """Run a scene; what is wrong with it."""
    from pgimp.case.schema import Case
    from pgimp.mpi.comm import Serial
    from pgimp.solver.simulation import Simulation

    class Forgetful(Serial):
        anew = True

    kept, other = (Simulation(Case.model_validate(case), comm) for comm in (Serial(), Forgetful()))
    count, made = _count_selections(kept, other)
    books, began, seconds, wrong = Books(kept), time.monotonic(), 0.0, []
    other.diagnostics()
    while kept.step < steps and not wrong:
        at, further = time.monotonic(), min(EVERY, steps - kept.step)
        failure = _advance(kept, further)
        seconds += time.monotonic() - at
        if failure != _advance(other, further):
            wrong.append("errors")
        if failure:  # alike
            print(f"{name}: ends with: {failure.splitlines()[0]}")
            break
        line = books.note(kept)
        wrong += [] if repr(line) == repr(other.diagnostics()) else ["history"]
        if kept.step % (EVERY * COMPARE) == 0 or wrong:
            wrong += _other(kept, other)
    print(
        f"{name}: {kept.count} particles, {kept.step} steps in {time.monotonic() - began:.0f} s "
        f"({seconds:.0f} s kept); {count() or 'no'} selections, {made()} anew"
    )
    print(f"  {books.said()}", flush=True)
    return [f"{name}: {', '.join(wrong)} differ at step {kept.step}"] * bool(wrong) + [
        f"{name}: {line}" for line in books.wrong()
    ]


def _advance(sim, steps):
    """Advance by some steps; the error that ends the run before, or ""."""
    from pgimp.errors import PgimpError

    try:
        for _ in range(steps):
            sim.advance()
    except PgimpError as error:
        return str(error)
    return ""


def _count_selections(*sims):
    """Functions that count the selections of simulations so far."""
    found = []
    for sim in sims:
        counts = [0]
        found.append(lambda counts=counts: counts[0])
        selector = getattr(sim.rank.contact, "_selector", None)
        if selector is not None:
            usual = selector.select

            def select(*args, usual=usual, counts=counts):
                counts[0] += 1
                return usual(*args)

            selector.select = select
    return found


def _other(one, other):
    """What of two simulations has not the same bits."""
    wrong = []
    for name in one.particles._fields:
        a, b = (getattr(sim.particles, name)[sim.live()] for sim in (one, other))
        if a.tobytes() != b.tobytes():
            wrong.append(name)
    ledgers = [sim.rank.ledger.contact.tobytes() for sim in (one, other)]
    if one.rank.grid.motion and ledgers[0] != ledgers[1]:
        wrong.append("ledger")
    return wrong


class Books:
    """Momentum that nothing gave, and energy that came from nowhere, of a run on the way."""

    def __init__(self, sim):
        self.gravity = [*sim.case.gravity, 0.0, 0.0][:2] if sim.case.gravity else [0.0, 0.0]
        self.last = sim.diagnostics()
        self.weight = self.momentum = self.energy = self.rise = self.off = 0.0
        self.lost, self.window = -np.inf, []

    def note(self, sim):
        """Keep the books of the steps since the last time; return the line of the history."""
        line, last = sim.diagnostics(), self.last
        passed = line["time"] - last["time"]
        for d, axis in enumerate("xy"):
            given = line["mass"] * self.gravity[d]
            for name in line:
                if name.startswith("reaction.") and name.endswith(f"-{axis}"):
                    given += line[name]
                elif name.startswith("rigid.") and name.endswith(f".force-{axis}"):
                    given -= line[name]
            self.weight += abs(line["mass"] * self.gravity[d] * passed)
            gained = line[f"momentum-{axis}"] - last[f"momentum-{axis}"]
            self.off = max(self.off, abs(gained - given * passed))
        moving = np.sqrt(2.0 * line["mass"] * line["kinetic-energy"])
        # Impulses are sums since the start, of the order of what the weight gave.
        self.momentum = max(self.momentum, moving, self.weight)
        self.energy = max(self.energy, line["kinetic-energy"] + line["strain-energy"])
        self.window.append(line["dissipated-energy"])
        if len(self.window) == WINDOW:
            mean, self.window = np.mean(self.window), []
            self.lost = max(self.lost, mean)
            self.rise = max(self.rise, self.lost - mean)
        self.last = line
        return line

    def said(self):
        """What drifted, in a line."""
        lost = self.last["dissipated-energy"] / self.energy
        return (
            f"momentum that nothing gave: {self.off / self.momentum:.1e}; of the greatest energy "
            f"{lost:.3f} lost, {self.rise / self.energy:.1e} gained at most"
        )

    def wrong(self):
        """What is wrong with them."""
        found = []
        if not self.off < 1e-12 * self.momentum:
            found.append(f"momentum is off by {self.off / self.momentum:.1e}")
        if not self.rise < GAIN * self.energy:
            found.append(f"energy grew by {self.rise / self.energy:.1e}")
        return found
