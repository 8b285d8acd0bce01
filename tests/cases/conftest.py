"""Runs of the cases."""

import pytest
from coarse_cases import CASES, COARSER

import pgimp
from pgimp.cli import main

#: Run on one rank only, which takes less time: what they have others have on two.
ALONE = {
    "hertz", "hertz-line", "rolling-ball", "corner", "drum", "sod", "slope", "channel", "graded",
    "excavation", "safety", "footing", "thick-tube", "jet", "hopkinson",
    "hopper", "cavity", "cone", "tunnel", "shaking", "shaken-slope", "poiseuille", "bagnold",
}  # fmt: skip
#: Of the others those that always run on two, one of each dimension, with contact, and of a flow.
TOGETHER = {"compaction", "disks", "block3d", "sand-column"}


@pytest.fixture(scope="module")
def runs(tmp_path_factory, mpirun, request):
    """``runs(name)`` is a case's run on one rank, from Python; on two most give the same bits."""
    together = COARSER.keys() - ALONE if request.config.option.all else TOGETHER
    folder = tmp_path_factory.mktemp("cases")
    results = {}

    def find(name):
        if name in results:
            return results[name]
        path, one, two = CASES / f"{name}.yaml", folder / f"{name}-1", folder / f"{name}-2"
        if name == "drum":  # its first grains, the lowest
            text = path.read_text(encoding="utf-8")
            path = folder / path.name
            path.write_text(text[: text.index("  g031:")], encoding="utf-8")
        found = pgimp.run(path, output=one, overrides=COARSER[name], quiet=True)
        if name not in together:
            results[name] = found
            return found
        words = ["-m", "pgimp", path, "-o", two, "--quiet"]
        done = mpirun(
            2, [*words, *(word for change in COARSER[name] for word in ("--set", change))]
        )
        assert done.returncode == 0, done.stderr
        assert pgimp.open(two).info["ranks"] == 2
        assert main(["compare", str(one), str(two)]) == 0
        results[name] = found
        return found

    return find
