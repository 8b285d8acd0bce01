"""A stress at the start widens boxes that follow the deformation: each rank has its particles."""

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
