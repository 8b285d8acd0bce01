"""Contact that keeps searches, selections and lists: the bits of one that makes them anew.

Small scenes of up to a hundred thousand steps, each run twice at once; see `scenes/anew.py`. Their
books are kept as well: momentum against what faces and weights give, and energy.
"""

import time

import numpy as np
from proofs.jobs import options_of
from proofs.scenes import anew, meetings

#: Steps between two lines of the history, which are compared, and lines between two comparisons of
#: all particles.
EVERY, COMPARE = 20, 50

#: Lines in a mean of the energy, as that of a step is of the first order in it, and part of the
#: greatest one by which means may grow.
WINDOW, GAIN = 25, 1e-3


def main(words):
    """Run the scenes; print what was compared, and what drifted."""
    options = options_of(
        "kept", words, quick="a hundredth of the steps",
        scene={"help": "this one alone"},
    )  # fmt: skip
    anew.prepare()
    wrong = []
    for name, (make, steps) in meetings.SCENES.items():
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
        at = time.monotonic()
        for _ in range(min(EVERY, steps - kept.step)):
            kept.advance()
        seconds += time.monotonic() - at
        while other.step < kept.step:
            other.advance()
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
                elif name.startswith("tool.") and name.endswith(f".force-{axis}"):
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
