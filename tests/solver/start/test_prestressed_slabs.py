"""Particles whose supports are not those of undeformed boxes: each rank has its own at the start.

A stress widens boxes that follow the deformation. Parts of cells have none.
"""

import pytest
from run_files import digests
from scenes import box, scene, write_case

pytestmark = pytest.mark.slow(30)

STRESS = """
import pgimp


@pgimp.stress
def tight(x, size):
    return size, size, size
"""


def test_a_bar_that_begins_under_tension_is_whole_on_any_ranks(tmp_path, mpirun):
    """Its boxes end at grid lines before they are widened: half of them reach one vertex more."""
    parts = {"start": {"stress": {"function": "tight", "parameters": {"size": 20.0}}}}
    case = scene(1, box([2.0], [14.0]), cells=[16], shape="cpdi", end=0.2, step=0.02, **parts)
    case["tractions"] = {"pull": {"body": "body", "face": "x-max", "traction": [1.0]}}
    case["output"] = {"every": 0.1}
    write_case(tmp_path / "bar.yaml", case)
    (tmp_path / "tight.py").write_text(STRESS)
    for ranks in (1, 3):
        words = ["-m", "pgimp", "bar.yaml", "--import", "tight.py", "-o", f"on-{ranks}"]
        job = mpirun(ranks, words, cwd=tmp_path)
        assert job.returncode == 0, job.stderr
    assert digests(tmp_path / "on-1") == digests(tmp_path / "on-3")


def test_parts_of_cells_beside_boxes_are_on_their_ranks(tmp_path, mpirun):
    """Cells are so long that rounding gives boxes of most layers, not parts, a vertex below."""
    bodies = {
        "initial": box([2.1, 1.2], [16.3, 3.1]) | {"formulation": "total-lagrangian"},
        "current": box([5.0, 3.3], [9.0, 5.2], [0.0, -1.0]),
    }
    case = scene(2, bodies, cells=[14, 7], cell=[1.263, 1.0], end=0.1, step={"courant": 0.3},
                 contact=[{"bodies": "all", "friction": 0.3}], output={"every": 0.05})  # fmt: skip
    write_case(tmp_path / "case.yaml", case)
    for ranks in (1, 3):
        job = mpirun(ranks, ["-m", "pgimp", "case.yaml", "-o", f"on-{ranks}"], cwd=tmp_path)
        assert job.returncode == 0, job.stderr
    assert digests(tmp_path / "on-1") == digests(tmp_path / "on-3")
