"""Forces of tractions in the history: against area times size, momentum, and over stages."""

import numpy as np
import pytest
from run_files import digests
from scenes import box, scene, start
from staged_bar import bar

import pgimp
from pgimp.mpi.comm import Serial

pytestmark = pytest.mark.slow(30)

LOW, HIGH = [2.2, 1.7], [6.1, 5.9]
WIDTH, HEIGHT = 3.9, 4.2


def loaded(configuration):
    """A free block under a pressure on a region, one on a face, and a traction on a face."""
    left = {"half-space": {"point": [3.0, 0.0], "normal": [1.0, 0.0]}}
    return scene(
        2,
        box(LOW, HIGH) | {"formulation": configuration},
        cells=[9, 9],
        step=0.002,
        tractions={
            "wet": {"body": "body", "region": left, "pressure": 2.0},
            "right": {
                "body": "body", "face": "x-max", "pressure": {"table": [[0.0, 1.0], [0.1, 9.0]]}
            },
            "top": {"body": "body", "face": "y-max", "traction": [0.3, -0.2]},
        },
    )  # fmt: skip


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_force_of_a_traction_is_size_times_area_and_all_make_up_the_momentum(configuration):
    sim = start(loaded(configuration))
    line = sim.diagnostics()
    assert all(line[f"traction.{name}-x"] == 0.0 for name in ("wet", "right", "top"))
    for n in range(30):
        last = line
        begin = sim.time
        for _ in range(1 + n % 3):
            sim.advance()
        line = sim.diagnostics()
        forces = np.array(
            [[line[f"traction.{name}-{axis}"] for name in ("wet", "right", "top")] for axis in "xy"]
        )
        if n == 0:
            # The side's ends reach half a cell along the other faces, which balance each other.
            exact = [[2.0 * HEIGHT, -1.0 * HEIGHT, 0.3 * WIDTH], [0.0, 0.0, -0.2 * WIDTH]]
            np.testing.assert_allclose(forces, exact, rtol=1e-12, atol=1e-9)
        gained = [line[f"momentum-{axis}"] - last[f"momentum-{axis}"] for axis in "xy"]
        took = sim.time - begin
        np.testing.assert_allclose(gained, took * forces.sum(axis=1), atol=1e-10)
    assert line["traction.right-x"] < -4.0 * HEIGHT


def test_forces_go_on_through_stages_and_resumed_runs(tmp_path):
    """A table of time, half of it in the second stage, and none in the third."""
    pull = {"body": "bar", "face": "x-max", "traction": {"table": [[0.0, [0.0]], [2.0, [2.0]]]}}
    stages = {"end": 2.0}, {"end": 2.2, "tractions": {"pull": None}}
    options = {"comm": Serial(), "quiet": True}
    more = {"constraints": {}, "tractions": {"pull": pull}, "waits": False}
    together = pgimp.run(bar(*stages, **more), output=tmp_path / "together", **options)
    for some in ((), stages[:1], stages):
        case = bar(*some, **more)
        folder = pgimp.run(case, output=tmp_path / "parts", resume=bool(some), **options).path
    assert digests(folder) == digests(together.path)
    time, force = (together.history[name] for name in ("time", "traction.pull-x"))
    pulled = (time > 0.0) & (time < 2.0 + 1e-9)
    # The load of a step is that at its beginning; a line is over ten.
    np.testing.assert_allclose(force[pulled], time[pulled] - 0.055, atol=1e-12)
    assert not np.nan_to_num(force[time > 2.0 + 1e-9]).any()
