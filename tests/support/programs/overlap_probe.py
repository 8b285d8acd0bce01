"""What tests/decomposition/test_overlap.py lets all ranks of one start do.

overlap_probe.py runs FOLDER CASE.yaml ...  runs cases with overlap, into FOLDER/on, and without,
                                            into FOLDER/off; there is little room for migration
overlap_probe.py memory CASE.yaml           steps a case; rank 0 prints a line of JSON a rank
"""

import gc
import json
import os
import sys
import tracemalloc
from pathlib import Path

from pgimp.case.reader import read_case
from pgimp.commands.run import run
from pgimp.decomposition import halo, migrate
from pgimp.mpi.comm import world
from pgimp.solver.simulation import RESORT, Simulation

#: Steps between two turns of all particles, steps to warm up, and steps until the end. For some
#: hundred steps Python still takes an arena of 1 MiB now and then for its small objects.
TURN, WARM, LAST = 60, 1200, 3000


def runs(folder, *cases):
    """With and without overlap; what was used is checked here."""
    halo.PIECE, migrate.CAPACITY = 1, 2
    seen = {"on": set(), "off": set()}
    rooms = [0]
    parts, send = halo.Halo.parts, migrate.Migration.proceed

    def noted(self, start):
        found = parts(self, start)
        seen[how].add(len(found))
        return found

    def sent(self, population, places):
        send(self, population, places)
        rooms.extend(link.to_send for link in self._links)

    halo.Halo.parts, migrate.Migration.proceed = noted, sent
    for how, value in (("on", "1"), ("off", "0")):
        os.environ[halo.SWITCH] = value
        for case in cases:
            run(case, output=folder / how / case.stem, quiet=True)
    comm = world()
    every = comm.allgather((seen, max(rooms)))
    if comm.size > 1:
        assert all(max(used["on"]) > 1 and used["off"] == {1} for used, _ in every), every
        assert max(most for _, most in every) > 2, every


def used():
    """Bytes that Python's objects and arrays take, and those of this process in memory."""
    gc.collect()  # also of objects that are kept to be used again
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return tracemalloc.get_traced_memory()[0], pages * os.sysconf("SC_PAGE_SIZE")


def memory(case):
    """Most that a step takes while it lasts, and what is there after few steps and after many."""
    comm = world()
    sim = Simulation(read_case(case.read_bytes(), str(case), {"time.end": 1000.0}), comm)
    most, after = 0, []
    tracemalloc.start()
    for step in range(LAST):
        if step % TURN == 0:
            sim.particles.v[:, 0] *= -1.0
        if step == WARM:
            after.append(used())
        tracemalloc.reset_peak()
        before = tracemalloc.get_traced_memory()[0]
        sim.advance(complete=False)
        if step > WARM and (step + 1) % RESORT:  # a re-sort is no part of a step
            most = max(most, tracemalloc.get_traced_memory()[1] - before)
    sim.complete_reduction()
    after.append(used())
    messages = sim.rank.halo.messages + sim.rank.migration.messages
    moved = sim.rank.migration.bytes - 8 * sim.rank.migration.messages
    found = {"most": most, "after": after, "messages": messages, "moved": moved}
    for line in comm.gather(found) or []:
        print(json.dumps(line))


if __name__ == "__main__":
    words = [Path(word) for word in sys.argv[2:]]
    {"runs": runs, "memory": memory}[sys.argv[1]](*words)
