"""Memory is estimated before it is taken; what does not fit is refused on every rank alike."""

import json
import resource
import shutil
import subprocess
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mentioned import mentions
from processes import PROGRAMS, clean_env
from scenes import box, scene, write_case

from pgimp.case.schema import Case
from pgimp.cli import main
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.mpi.limits import Limit, limits
from pgimp.scene.bodies import extent
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.scene import Scene
from pgimp.solver.start import require_memory

pytestmark = pytest.mark.slow(30)

GB = 10**9
WALLS = {"x-min": "fixed", "x-max": "fixed", "y-min": "slip", "y-max": "slip"}


def square(cells, **parts):
    """A square body that fills most of a domain of so many cells along each direction."""
    body = box([2.0] * 2, [cells - 2.0] * 2)
    return scene(2, body, cells=[cells] * 2, step=1e-3, boundaries=WALLS, **parts)


@pytest.mark.parametrize(("ranks", "cells"), [(1, 500), (2, 600)])
def test_the_estimate_is_what_a_run_takes(tmp_path, mpirun, python, ranks, cells):
    found = {}
    for n in (40, 40, cells):  # the first one may compile, which takes more than its particles
        folder = tmp_path / str(n)
        folder.mkdir(exist_ok=True)
        write_case(folder / "case.yaml", square(n))
        for name in ("frames", "checkpoints"):
            shutil.rmtree(folder / name, ignore_errors=True)
        args = [PROGRAMS / "memory_probe.py", folder / "case.yaml", folder]
        run = python(args) if ranks == 1 else mpirun(ranks, args)
        assert run.returncode == 0, run.stderr
        found[n] = [json.loads((folder / f"{r}.json").read_text()) for r in range(ranks)]
    for small, large in zip(*found.values(), strict=True):
        taken = large["peak"] - small["peak"]
        for before, after in zip(small["estimates"], large["estimates"], strict=True):
            assert taken > 1.5e8
            assert after - before == pytest.approx(taken, rel=0.25)


class Others:
    """A communicator in which this rank gathers with others of the same needs."""

    def __init__(self, bounds):
        self.bounds, self.rank, self.size = bounds, 0, len(bounds)

    def allgather(self, mine):
        return [(mine[0], bounds) for bounds in self.bounds]


def refusal(case, bounds):
    with pytest.raises(require_memory.MemoryShortError) as caught:
        require_memory.require(Scene(Case.model_validate(case)), Others(bounds))
    return str(caught.value)


def test_what_the_ranks_of_a_node_need_together_must_be_there():
    case = square(3002)  # 36 million particles of some 400 bytes
    a, b = Limit("a", "this node", 8 * GB), Limit("b", "this node", 8 * GB)
    require_memory.require(Scene(Case.model_validate(case)), Others([[a], [a], [b], [b], [a], [b]]))
    text = refusal(case, [[a], [a], [b], [a], [a], [b]])
    mentions(text, "too large", "4 of 6 ranks", "this node leaves 8 GB\n", "GB a rank")
    mentions(text, "3.59e+07 particles", "grid.cell", "more nodes")
    # The tightest of several limits counts, also that of a single process.
    own = Limit("process 7", "ulimit -v", 1 * GB, True)
    assert "ulimit -v leaves 1 GB" in refusal(case, [[a], [b], [a, own], [b], [a], [b]])


@pytest.mark.parametrize(
    ("changes", "most"),
    [
        ({"cells": [10**7, 4]}, "addresses of the grid's"),
        ({"cells": [10**6, 10**6]}, "particles ("),
        ({"cells": [4, 10**7], "cell": [1.0, 1e-3]}, "particles ("),
        ({"per_cell": [2**53, 2**53]}, "particles ("),
        ({"per_cell": [1, 2**53]}, "particles ("),
        ({"bodies": 500, "cells": [10**6, 16]}, "sums over 500 bodies"),
    ],
)  # fmt: skip
def test_whatever_is_large_is_named(changes, most):
    cells, each = changes.get("cells", [8, 8]), changes.get("cell", [1.0, 1.0])
    size = [n * h for n, h in zip(cells, each, strict=True)]
    body = box([0.0] * 2, size)
    if "addresses" in most:
        body = box([1.0] * 2, [3.0] * 2)
    if count := changes.pop("bodies", 0):
        body = {f"b{i}": box([2.0 * i, 1.0], [2.0 * i + 1.0, 2.0]) for i in range(count)}
    case = scene(2, body, step={"courant": 0.3}, **changes)
    text = refusal(case, [[Limit("a", "ulimit -v", GB // 2, True)]])
    assert most in text.splitlines()[1]


def test_a_case_that_is_too_large_is_refused_at_once(tmp_path, python):
    """In 3 to 4 times the time in which a small one is checked five times."""
    write_case(tmp_path / "small.yaml", square(4, end=1.0))
    write_case(tmp_path / "case.yaml", square(400000, end=1.0))
    program = (
        "import sys, time; from pgimp.cli import main; main(['check', 'small.yaml'])\n"
        "began = time.process_time(); [main(['check', 'small.yaml']) for _ in range(5)]\n"
        "small = time.process_time()\n"
        "status = [main([*words, 'case.yaml']) for words in ([], ['check'])]\n"
        "times = (time.process_time() - small) / (small - began)\n"
        # The greatest of getrusage would be that of the process which started this one.
        "text = open('/proc/self/status').read()\n"
        "taken = int(text.split('VmHWM:')[1].split()[0]) / 1e3\n"
        "print('took', taken, times); sys.exit(10 * status[0] + status[1])"
    )
    run = python(["-c", program], cwd=tmp_path)
    assert run.returncode == 22
    assert run.stderr.count("this case is too large: it would take about ") == 2
    assert "particles        about 6.4e+11" in run.stdout  # of the check
    megabytes, times = map(float, run.stdout.split("took ")[1].split())
    assert megabytes < 300 and times < 20.0, times
    assert not (tmp_path / "case.out").exists()


def test_under_mpirun_every_rank_refuses(tmp_path, mpirun):
    write_case(tmp_path / "case.yaml", square(400000, end=1.0))
    run = mpirun(2, ["-m", "pgimp", "case.yaml"], cwd=tmp_path)
    assert run.returncode == 2
    assert run.stderr.count("too large") == 1
    assert "2 of 2 ranks would take about " in run.stderr
    assert not (tmp_path / "case.out").exists()


def test_the_limits_of_a_process_are_found():
    most = 40 * GB
    program = "from pgimp.mpi.limits import limits; print(limits()[-1].free)"
    run = subprocess.run(
        [sys.executable, "-c", program],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (most, most)),
        env=clean_env(),
        capture_output=True,
        check=True,
    )
    assert 0.9 * most < int(run.stdout) < most
    here = {limit.name: limit for limit in limits()}
    assert here["this node"].free > 0


def system(folder, files):
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return [limit for limit in limits(str(folder)) if not limit.name.startswith("ulimit")]


def test_limits_of_the_node_and_of_cgroups_are_found(tmp_path):
    files = {
        "proc/meminfo": "MemTotal: 100 kB\nMemAvailable:   70 kB\nSwapTotal: 5 kB\n"
        "CommitLimit: 90 kB\nCommitted_AS: 30 kB\n",
        "proc/sys/kernel/random/boot_id": "node-1\n",
        "proc/sys/vm/overcommit_memory": "0\n",
        "proc/self/cgroup": "3:cpu:/x\n4:memory,hugetlb:/job/step\n0::/\n",
        "sys/fs/cgroup/memory/job/memory.limit_in_bytes": "50000\n",
        "sys/fs/cgroup/memory/job/memory.usage_in_bytes": "30000\n",
        "sys/fs/cgroup/memory/job/memory.stat": "total_active_file 5000\ntotal_inactive_file 10\n",
        "sys/fs/cgroup/memory/job/step/memory.limit_in_bytes": "9223372036854771712\n",
        "sys/fs/cgroup/memory/job/step/memory.usage_in_bytes": "30000\n",
    }
    first = tmp_path / "v1"
    found = {
        limit.name.removeprefix(f"the cgroup {first}/"): limit for limit in system(first, files)
    }
    assert found["this node"][::2] == ("node-1", 70 * 1024)
    assert found["the whole memory of this node"].free == 105 * 1024
    assert found["the whole memory of this node"].addresses
    assert found["sys/fs/cgroup/memory/job"].free == 25010
    assert len(found) == 3

    files |= {
        "proc/sys/vm/overcommit_memory": "2\n",
        "proc/self/cgroup": "0::/a/b\n",
        "sys/fs/cgroup/a/b/memory.max": "max\n",
        "sys/fs/cgroup/a/b/memory.current": "1000\n",
        "sys/fs/cgroup/a/memory.max": "8000\n",
        "sys/fs/cgroup/a/memory.current": "6000\n",
        "sys/fs/cgroup/a/memory.stat": "anon 1\nactive_file 100\ninactive_file 900\n",
    }
    second = tmp_path / "v2"
    found = {
        limit.name.removeprefix(f"the cgroup {second}/"): limit for limit in system(second, files)
    }
    assert found["sys/fs/cgroup/a"].free == 3000
    assert found["vm.overcommit_memory=2"].free == 60 * 1024
    # A container whose cgroup has another name outside; a system without any of these files.
    outside = {"proc/self/cgroup": "0::/../up\n", "sys/fs/cgroup/memory.max": "7\n",
               "sys/fs/cgroup/memory.current": "3\n"}  # fmt: skip
    (only,) = system(tmp_path / "container", outside)
    assert only.free == 4
    assert system(tmp_path / "none", {}) == []


@settings(max_examples=60, deadline=None)
@given(
    D=st.integers(1, 3),
    radius=st.floats(0.3, 3.9),
    at=st.floats(0.0, 1.0),
    kind=st.sampled_from(["ball", "box", "holed"]),
    looks=st.sampled_from([1, 30, 400_000]),
)
def test_particles_are_counted_from_the_outside(D, radius, at, kind, looks):
    centre = [4.0 + at * (4.0 - radius) / (d + 1) for d in range(D)]
    ball = {"ball": {"centre": centre, "radius": radius}}
    corners = {"min": [c - radius for c in centre], "max": [c + radius for c in centre]}
    holed = {"difference": [{"box": corners}, ball]} if D > 1 else {"box": corners}
    region = {"ball": ball, "box": {"box": corners}, "holed": holed}[kind]
    case = Case.model_validate(scene(D, {"material": "soft", "region": region}, per_cell=3))
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(extent, "_LOOKS", looks)
        (found,) = extent.extents(case)
    try:
        lattice, counts, _ = count_particles(Scene(case), Serial())
    except CaseError:
        return
    assert found.least <= counts.sum() <= found.most
    bounds = zip(*case.bodies["body"].region.bounds(), strict=True)
    each = zip(found.low, found.high, strict=True)
    boxes = lattice.bodies[0].box
    for ends, own, exact, edges in zip(bounds, each, boxes, lattice.edges, strict=True):
        for end, mine, theirs in zip(ends, own, exact, strict=True):
            # Where the body ends at the edge of a box, rounding says whether it is in the next.
            at_edge = min(abs(edge - end) for edge in edges) < 1e-12
            assert mine == theirs or (abs(mine - theirs) == 1 and at_edge)


def test_long_boxes_are_counted_in_few_looks(monkeypatch):
    """A brick two boxes wide, of boxes four times as long as wide: it is divided across."""
    case = scene(2, {"material": "soft", "region": {"box": {"min": [3.1, 3.1], "max": [7.0, 6.9]}}})
    case["grid"] |= {"size": [8.0, 8.0], "cell": [4.0, 1.0]}
    case["method"]["particles-per-cell"] = [1, 1]
    distances = []
    region = type(Case.model_validate(case).bodies["body"].region)
    asked = region.distance
    monkeypatch.setattr(region, "distance", lambda *a: distances.append(1) or asked(*a))
    (found,) = extent.extents(Case.model_validate(case))
    assert len(distances) < 20
    assert found.least <= 4 <= found.most


def test_a_run_that_would_never_end_is_refused(tmp_path, capsys):
    write_case(
        tmp_path / "case.yaml",
        square(8, end=1e15) | {"time": {"end": 1e15, "step": {"courant": 0.3}}},
    )
    for words in (["check"], []):
        assert main([*words, str(tmp_path / "case.yaml")]) == 2
        assert "the end at 1e+15 is 3.87e+16 steps away" in capsys.readouterr().err
