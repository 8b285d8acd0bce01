"""The paper's column under its own weight (4.1)."""

from scenes import scene

YOUNG, LENGTH, RATE = 1.0e6, 50.0, -400.0


def column(cell, per_cell, shape, volume, end, step):
    bar = {"model": "linear-1d", "young": YOUNG, "density": 1.0}
    body = {"material": "bar", "region": {"box": {"min": [0.0], "max": [LENGTH]}}}
    return scene(
        1,
        body,
        cells=[round(55.0 / cell)],
        cell=cell,
        per_cell=per_cell,
        shape=shape,
        volume=volume,
        end=end,
        step=step,
        materials={"bar": bar},
        gravity={"table": [[0.0, [0.0]], [2.0, [2.0 * RATE]]]},
        boundaries={"x-min": "fixed"},
    )
