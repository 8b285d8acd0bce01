"""A block that flies for 20 steps, for programs that use pgimp from Python."""

from scenes import box, scene

BLOCK = scene(2, box([2, 1], [5, 4], [0.3, -0.2]), gravity=[0.0, -5.0], end=0.2) | {
    "boundaries": {"y-min": "slip"},
    "output": {"every": 0.1, "fields": ["stress", "velocity", "displacement"]},
    "history": {"every": {"steps": 5}},
    "probes": {"tip": {"body": "body", "at": [5.0, 4.0]}},
}
