"""Cases on other cells: steps, intervals and lines go with them; what cannot is refused."""

import pytest
from two_blocks import flying

from pgimp.case.accuracy.rescaled import companion, rescaled
from pgimp.case.load import load
from pgimp.errors import UsageError
from pgimp.utilities.accuracy.estimate import ratio_of


def test_steps_and_intervals_go_with_the_cells():
    case = load(flying(history={"every": {"steps": 40}}, output={"every": 0.5, "at": [1.0]}))
    large = rescaled(case, 2.0)
    assert large.grid.cell == (2.0, 2.0) and large.grid.size == case.grid.size
    assert large.time.step == 0.02 and large.time.steps == 100
    assert large.history.every.steps == 20 and large.output == case.output
    assert large.method == case.method and large.bodies == case.bodies
    small = rescaled(case, 0.7)  # 17 and 9 cells; steps not longer than these cells allow
    assert small.grid.cells == (17, 9)
    assert small.time.step <= 0.01 * min(small.grid.cell) * (1.0 + 1e-9)
    dense = companion(case, 2.0)
    assert dense.history.every.steps == 5 and dense.output.every is None
    assert dense.output.at == (1.0,)
    assert ratio_of(dense.grid.cell, case.grid.cell) == 2.0


def test_ends_of_stages_are_whole_numbers_of_steps():
    stages = [{"name": "on", "end": 2.5, "history": {"every": {"steps": 4}}},
              {"name": "slow", "end": 3.1, "step": 0.03}]  # fmt: skip
    data = flying(probes={"p": {"body": "a", "at": [2.0, 2.0], "every": {"steps": 8}}})
    data["time"]["stages"] = stages
    case = load(data)
    for factor in (2.0, 3.0, 1.7, 0.6):
        found = companion(case, factor)
        ends = [stage.time.end for stage in found.stages]
        assert ends == [2.0, 2.5, 3.1]
        for own, other in zip(case.stages, found.stages, strict=True):
            longer = min(found.grid.cell) / min(case.grid.cell)
            assert 0.5 * longer * own.time.step < other.time.step <= 1.001 * longer * own.time.step
        assert found.stages[1].history.every.steps == max(1, round(4 / longer) // 4)
        assert found.probes["p"].every.steps == max(1, round(8 / longer) // 4)


def test_a_periodic_direction_of_few_cells_keeps_them():
    faces = {"y-min": "periodic", "y-max": "periodic"}
    data = flying() | {"boundaries": faces}
    data["bodies"]["a"]["region"] = {"box": {"min": [1.0, 0.0], "max": [4.0, 6.0]}}
    del data["bodies"]["b"]
    found = rescaled(load(data), 4.0)
    assert found.grid.cells == (3, 4)


def test_a_domain_grows_beyond_open_faces_to_whole_cells():
    """So that surfaces on lines of the grid stay on them; elsewhere cells change a little."""
    data = flying() | {"boundaries": {"x-min": "fixed", "y-max": "slip"}}
    data["grid"] = {"origin": [0.0, 1.0], "size": [13.0, 5.0], "cell": [1.0, 1.0]}
    for body in data["bodies"].values():
        body["region"]["box"]["min"][1] = 2.0
    found = rescaled(load(data), 2.0).grid
    assert (found.cell, found.size, found.origin) == ((2.0, 2.0), (14.0, 6.0), (0.0, 0.0))
    data["time"]["stages"] = [{"name": "shut", "end": 3.0, "boundaries": {"x-max": "slip"}}]
    found = rescaled(load(data | {"outflow": {"y-min": "remove"}}), 2.0).grid
    assert found.size == (13.0, 5.0) and found.cells == (6, 2)
    rings = data | {"geometry": "axisymmetric", "boundaries": {"x-max": "slip", "y-min": "slip"}}
    rings["time"] = {"end": 2.0, "step": 0.01}
    del rings["bodies"]["a"]["velocity"]
    found = rescaled(load(rings), 2.0).grid
    assert found.origin[0] == 0.0 and found.size == (13.0, 6.0)


def test_particles_of_a_file_are_refused(tmp_path):
    (tmp_path / "p.csv").write_text("x,y,volume\n1.25,1.25,0.25\n1.75,1.25,0.25\n")
    data = flying()
    data["bodies"]["a"]["region"] = {"points": {"file": str(tmp_path / "p.csv")}}
    with pytest.raises(UsageError, match=r"bodies\.a: its particles come from a file"):
        rescaled(load(data), 2.0)
