"""Messages on their way while layers are summed; the same bits without; nothing allocated."""

import hashlib
import json

import pytest
from loaded_block import loaded
from overlap_probe import LAST, WARM
from processes import PROGRAMS
from scenes import box, scene, write_case
from tiers import wide

from pgimp.decomposition.halo import Halo
from pgimp.decomposition.slabs import Slab
from pgimp.errors import UsageError

pytestmark = pytest.mark.slow(90)

PROBE = PROGRAMS / "overlap_probe.py"
FACES = {"x-min": "fixed", "x-max": "fixed", "y-min": "slip", "y-max": "slip"}


def digests(run):
    """Of all frames, and of the history."""
    files = [*sorted((run / "frames").iterdir()), run / "history.csv"]
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def flying():
    """Two blocks fly fast past all slabs, and meet."""
    bodies = {
        "right": box([1.0, 1.0], [6.0, 5.0], [12.0, 0.5]),
        "left": box([18.0, 2.0], [22.0, 6.0], [-10.0, -0.5]),
    }
    return scene(
        2, bodies, cells=[24, 8], end=0.9, boundaries=FACES,
        output={"every": 0.3, "fields": ["velocity", "stress"]}, history={"every": {"steps": 10}},
    )  # fmt: skip


def test_overlap_does_not_change_a_bit(mpirun, python, tmp_path):
    """Nor do constraints' marks, and crowds of particles too large for the room in a message.

    Of three slabs two have one neighbour and one has two.
    """
    cases = {"flying": flying(), "loaded": loaded()}
    for name, case in cases.items():
        write_case(tmp_path / f"{name}.yaml", case)
    words = [f"{tmp_path / name}.yaml" for name in cases]
    alone = python([PROBE, "runs", tmp_path / "1", *words], 300)
    assert alone.returncode == 0, alone.stderr
    job = mpirun(3, [PROBE, "runs", tmp_path / "3", *words], 300)
    assert job.returncode == 0, job.stderr
    for name in cases:
        expected = digests(tmp_path / "1" / "on" / name)
        for how in ("on", "off"):
            assert digests(tmp_path / "3" / how / name) == expected, (how, name)


@pytest.mark.parametrize("ranks", [wide(1), 2])
def test_a_step_allocates_nothing(mpirun, python, tmp_path, ranks):
    """Particles come and go all the time: little objects, no arrays, and none of them stay."""
    body = box([2.0, 1.0], [22.0, 7.0], [4.0, 0.0])
    case = scene(2, body, cells=[28, 8], per_cell=6, step=0.005, end=12.0, boundaries=FACES)
    write_case(tmp_path / "case.yaml", case)
    words = [PROBE, "memory", tmp_path / "case.yaml"]
    job = python(words) if ranks == 1 else mpirun(ranks, words, env={"PGIMP_BALANCE": "0"})
    assert job.returncode == 0, job.stderr
    for rank in map(json.loads, job.stdout.splitlines()):
        (few, resident), (many, at_end) = rank["after"]
        assert rank["most"] < 8000  # four bytes for each of the rank's particles take more
        # Not even a tuple a step stays, which takes 48 bytes at least; Python keeps some hundred
        # to be used again.
        assert many - few < 48 * (LAST - WARM)
        # An arena may come yet, of Python's or of the messages'; what each step leaves is more.
        assert at_end - resident < 1_500_000
        if ranks > 1:
            # The exchange and migration, one each; a few times more move than there is room.
            assert 2 * LAST <= rank["messages"] <= 2 * LAST + 9
            assert rank["moved"] > 100_000


def test_a_switch_that_means_nothing_is_refused(monkeypatch):
    monkeypatch.setenv("PGIMP_OVERLAP", "yes")
    with pytest.raises(UsageError, match="PGIMP_OVERLAP is 'yes'; 0 lets"):
        Halo(None, Slab(0, 4, None, None), 2)
