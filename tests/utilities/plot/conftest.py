"""Runs to be plotted, and the command."""

import pytest
from scenes import box, scene, write_case

from pgimp import cli

FIELDS = ["velocity", "stress", "pressure", "von-mises"]


def make(folder, name, dimension, fields=FIELDS, **parts):
    """Run a small case in a folder."""
    parts = {
        "output": {"every": 0.05, "fields": fields},
        "history": {"every": {"steps": 1}},
    } | parts
    write_case(folder / f"{name}.yaml", scene(dimension, end=0.1, **parts))
    assert (
        cli.main([str(folder / f"{name}.yaml"), "-o", str(folder / f"{name}.out"), "--quiet"]) == 0
    )


@pytest.fixture(scope="module")
def runs(request, tmp_path_factory):
    """Those that the module names in `RUNS`, as it would wait for all of them.

    A bar that is pulled, two plates of which one falls, the same with other fields, a block.
    """
    folder = tmp_path_factory.mktemp("plot")
    held = {"box": {"min": [1], "max": [3]}}, {"box": {"min": [5], "max": [7]}}
    pull = {"table": [[0.0, 0.0], [0.06, 0.3], [0.1, 0.0]]}
    ends = {"wall": (held[0], 0.0), "grip": (held[1], pull)}
    constraints = {
        name: {"body": "body", "region": region, "velocity": [velocity]}
        for name, (region, velocity) in ends.items()
    }
    probes = {
        "tip": {"body": "body", "at": [5.8]},
        "slow": {"body": "body", "at": [4], "every": {"steps": 3}},
        "place": {"place": [4]},
    }
    bar = {"constraints": constraints, "probes": probes, "history": {"every": {"steps": 2}}}
    plates = {"low": box([1, 1], [4, 3], [0.3, -0.2]), "high": box([4.5, 4], [7, 7])}
    falling = {"body": plates, "gravity": [0, -9], "boundaries": {"y-min": "unilateral"}}
    thick = box([2, 2, 2], [6, 5, 4], [0.2, 0.1, 0.3])
    known = {
        "bar": (1, {"body": box([2], [6], [0.5]), "units": "mm, t, s", **bar}),
        "plates": (2, {"units": "m, kg, s", **falling}),
        "other": (
            2,
            {"fields": ["stress"], "body": plates, "gravity": [0, -5], "units": "m, kg, s"},
        ),
        "block": (3, {"body": thick, "gravity": [0, 0, -9]}),
    }
    for name in request.module.RUNS:
        dimension, parts = known[name]
        make(folder, name, dimension, **parts)
    return folder


@pytest.fixture
def plot(runs, tmp_path, monkeypatch, capsys):
    """``plot("bar.out", ...)`` in a folder of its own: status, output and errors."""
    for path in runs.iterdir():
        (tmp_path / path.name).symlink_to(path)
    monkeypatch.chdir(tmp_path)

    def call(*words):
        status = cli.main(["plot", *map(str, words)])
        said = capsys.readouterr()
        assert "Traceback" not in said.err
        return status, said.out, said.err

    return call
