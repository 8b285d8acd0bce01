"""A bar in 1D whose free end is gripped, and another that waits beside it, in stages."""

from scenes import box, scene, start

E, LENGTH, STEP = 100.0, 8.0, 0.01
#: Crosses the bar in 0.8.
SPEED = 10.0
#: A stretched bar, so that the grip has pulled its last particle by a hundredth of its length.
PULLED = {"body": "bar", "region": {"box": {"min": [7.5], "max": [8.0]}}, "velocity": [0.08]}


def bar(*stages, waits=True, **parts):
    bodies = {"bar": box([0.0], [LENGTH])}
    if waits:
        bodies["waits"] = box([11.0], [13.0], [0.5])
    case = scene(
        1,
        bodies,
        cells=[16],
        **{
            "step": STEP,
            "boundaries": {"x-min": "fixed"},
            "constraints": {"grip": PULLED},
            "output": {"every": 0.25},
            "history": {"every": {"steps": 10}},
        }
        | parts,
    )
    if stages:
        case["time"]["stages"] = [
            {"name": f"stage{i}", **each} if "name" not in each else each
            for i, each in enumerate(stages)
        ]
    return case


def entered(case):
    """The simulation of a case at the beginning of its second stage, and the line before."""
    sim = start(case)
    sim.diagnostics()
    while not sim.stage_done:
        sim.advance()
    line = sim.diagnostics()
    sim.next_stage()
    return sim, line


DIG = {
    "name": "dig", "end": 1.5, "remove": ["waits"], "materials": {"soft": {"young": 50.0}},
    "gravity": [-1.0], "constraints": {"grip": {"velocity": [-0.05]}},
}  # fmt: skip
HOLD = {
    "name": "hold", "end": 2.1, "step": {"courant": 0.2}, "boundaries": {"x-max": "slip"},
    "constraints": {"base": {"body": "bar", "region": {"box": {"min": [0.0], "max": [2.0]}},
                             "velocity": [0.0]}},
}  # fmt: skip
