"""pgimp from Python on several ranks: the same bits, and an end with the reason, never a hang."""

import json
import os

import numpy as np
import pytest
from scenes import write_case
from small_block import BLOCK

import pgimp


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with the case of the block."""
    folder = tmp_path_factory.mktemp("python")
    write_case(folder / "block.yaml", BLOCK)
    return folder


LOOP = """
import json, sys
import numpy as np
import pgimp

case = pgimp.load("block.yaml")
comm = pgimp.world()
for young in np.array([100.0, 50.0]):
    run = pgimp.run(case, output=f"two-{young:g}", overrides={"materials.soft.young": young})
    assert run.state == "done" and len(run.frame(-1)) == 36
sim = pgimp.Simulation(case)
sim.advance()
rows = comm.gather((sim.particles["id"].tolist(), sim.particles["position"].tolist()))
if comm.rank == 0:
    json.dump([comm.size, rows], open("rows.json", "w"))
"""


def test_a_program_on_two_ranks_has_the_same_bits(folder, mpirun):
    (folder / "loop.py").write_text(LOOP)
    done = mpirun(2, ["loop.py"], cwd=folder)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("done: t = 0.2 after 20 steps") == 2
    for young in (100.0, 50.0):
        change = {"materials.soft.young": young}
        one = pgimp.run(BLOCK, output=folder / f"one-{young:g}", overrides=change, quiet=True)
        two = pgimp.open(folder / f"two-{young:g}")
        assert two.info["ranks"] == 2
        for mine, others in zip(one, two, strict=True):
            for name in mine:
                np.testing.assert_array_equal(mine[name], others[name])
    size, rows = json.loads((folder / "rows.json").read_text())
    ids = np.concatenate([one[0] for one in rows])
    assert size == 2 and len(rows) == 2 and sorted(ids) == list(range(36))
    positions = np.concatenate([one[1] for one in rows])[np.argsort(ids)]
    sim = pgimp.Simulation(BLOCK)
    sim.advance()
    np.testing.assert_array_equal(positions, sim.particles["position"])


TOGETHER = """
import sys
import pgimp
from pgimp.mpi.comm import Serial

comm, case = pgimp.world(), pgimp.load("block.yaml")
"""


@pytest.mark.parametrize(
    ("program", "status", "words"),
    [
        ("sim = pgimp.Simulation(case)\nif comm.rank == 1:\n    raise ValueError('here')\n"
         "sim.advance()", 1, "ValueError: here"),
        ("if comm.rank == 1:\n    pgimp.Simulation(case)", 1,
         "rank 1: rank 0 has ended, and pgimp.Simulation needs all ranks"),
        ("if comm.rank == 0:\n    pgimp.run(case, output='one')\nelse:\n    comm.Barrier()", 1,
         "rank 0: rank 1 has not come to pgimp.run within 1 seconds"),
        ("pgimp.Simulation(case, overrides={'time.end': 0.1 * (1 + comm.rank)}).advance()", 2,
         "rank 1 would do it with another case or other arguments than rank 0"),
        ("pgimp.run(case, output='two', overrides={'time.end': 0.1 * (1 + comm.rank)})", 2,
         "rank 1 would do it with another case or other arguments than rank 0"),
        ("if comm.rank == 1:\n    pgimp.Simulation(case, Serial()).step(2)", 0, ""),
    ],
)  # fmt: skip
def test_ranks_that_do_not_come_together_end_with_the_reason(
    folder, mpirun, program, status, words
):
    (folder / "apart.py").write_text(TOGETHER + program)
    done = mpirun(2, ["apart.py"], 60.0, cwd=folder, env=os.environ | {"PGIMP_PATIENCE": "1"})
    assert done.returncode == status, done.stderr
    assert words in done.stderr and not (folder / "two").exists()


BEGUN = (
    TOGETHER
    + """
import time
sim = pgimp.Simulation(case)
sim.step()
"""
)

DIFFERENT = """
two = pgimp.Simulation(case)
for act in (
    lambda: sim.step(2 + comm.rank),
    lambda: sim.advance(0.1 if comm.rank else 0.05),
    lambda: sim.step() if comm.rank else sim.diagnostics(),
    lambda: (two if comm.rank else sim).step(),
):
    try:
        act()
    except pgimp.errors.UsageError as error:
        print(f"rank {comm.rank}: {error}", flush=True)
assert sim.steps == 1 and two.steps == 0
sim.step()
if comm.rank == 1:
    time.sleep(3)  # ranks may look at what they have as long as they like
sim.core.advance = lambda: sys.exit(0)
sim.step()
"""


def test_ranks_that_do_different_things_are_told_on_all_and_can_go_on(folder, mpirun):
    (folder / "different.py").write_text(BEGUN + DIFFERENT)
    env = os.environ | {"PGIMP_PATIENCE": "10"}
    done = mpirun(2, ["different.py"], 60.0, cwd=folder, env=env)
    assert done.returncode == 0, done.stderr
    for rank in (0, 1):
        for words in (
            "rank 0 does step(2) of simulation 1, rank 1 step(3) of simulation 1",
            "rank 0 does advance(0.05) of simulation 1, rank 1 advance(0.1) of simulation 1",
            "rank 0 does diagnostics() of simulation 1, rank 1 step(1) of simulation 1",
            "rank 0 does step(1) of simulation 1, rank 1 step(1) of simulation 2",
        ):
            assert f"rank {rank}: {words}; all ranks do the same" in done.stdout


@pytest.mark.parametrize(
    ("ranks", "program", "words"),
    [
        (3, "for _ in range(3 - comm.rank // 2):\n    sim.step()",
         "rank 0: rank 2 has ended, and step(1) of simulation 1 needs all ranks"),
        (2, "if comm.rank == 0:\n    sys.exit(0)\npgimp.run(case, output='two')",
         "rank 1: rank 0 has ended, and pgimp.run needs all ranks"),
        (2, "if comm.rank == 1:\n    sim.core.advance = lambda: sys.exit(0)\nsim.step()",
         "rank 1 has ended within step(1) of simulation 1, and others wait for it"),
        (2, "if comm.rank == 0:\n    comm.Barrier()\nsim.step()",
         "rank 1: others have not come to step(1) of simulation 1 within 2 seconds"),
    ],
)  # fmt: skip
def test_ranks_that_wait_for_one_that_has_ended_end(folder, mpirun, ranks, program, words):
    (folder / "parting.py").write_text(BEGUN + program)
    env = os.environ | {"PGIMP_PATIENCE": "2"}
    done = mpirun(ranks, ["parting.py"], 60.0, cwd=folder, env=env)
    assert done.returncode == 1, done.stderr
    assert words in done.stderr and not (folder / "two").exists()
