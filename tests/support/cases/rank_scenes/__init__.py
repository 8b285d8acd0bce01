"""Scenes whose bodies cross slabs, for whole runs on several ranks."""

from exact_cases import bar, ramp, ring
from loaded_block import loaded

from rank_scenes.arrivals import lifts, pours, streams
from rank_scenes.averaged import (
    averaged_contact,
    averaged_grip,
    averaged_lattice,
    averaged_layers,
    averaged_surfaces,
)
from rank_scenes.damped_bodies import damped, dug, heavy, pressed, quaking, settled, soaked
from rank_scenes.entries import GRID, PAIR
from rank_scenes.flights import (
    cut,
    line_gimp,
    line_mpm,
    line_slows,
    narrow,
    plane_gimp,
    plane_mpm,
    space_gimp,
    space_mpm,
)
from rank_scenes.gauged import GAUGED, gauged
from rank_scenes.initial_bodies import (
    both_configurations,
    exact_contact,
    exact_means,
    exact_rings,
    exact_round,
    exact_skins,
    exact_surfaces,
    initial,
    initial_contact,
    initial_lattice,
    initial_stages,
    surface_beside,
    surface_boxes,
    surface_contact,
    surface_stages,
)
from rank_scenes.laws import VARIED, affine, flowing, metals, varied
from rank_scenes.leaving import PROBES, line_leaves, plane_leaves, sinks
from rank_scenes.meetings import meeting, phased, staged, surface_blocks, surface_folded
from rank_scenes.passing import passing
from rank_scenes.periods import (
    endless,
    layer,
    mixed_flows,
    mixed_round,
    rigid_round,
    round_and_round,
    surface_round,
)
from rank_scenes.plates import plates, plates_initial
from rank_scenes.rings import (
    mixed_rings,
    rings,
    rings_free,
    rings_initial,
    rings_initial_contact,
    surface_rings,
)
from rank_scenes.squeezed_blocks import SIZED
from rank_scenes.turned import turned

#: What tests take from here besides.
__all__ = [
    "EXACT", "GRID", "PAIR", "PROBES", "SCENES", "SIZED", "VARIED", "line_gimp", "meeting",
    "plane_leaves", "plane_mpm", "space_gimp",
]  # fmt: skip

#: Of cases with an exact solution.
_SHORT = {
    "shape": "finite-gimp",
    "output": {"every": 0.1, "fields": ["velocity", "stress", "displacement"]},
    "history": {"every": {"steps": 5}},
}
#: Body forces, initial velocities and the errors of exact solutions.
EXACT = {
    "ring": ring(0.125, end=0.2, **_SHORT),
    "bar": bar(
        {"compaction": {"dynamic": True}},
        gravity=ramp((0.0, 0.0), (1.0, -6.0)),
        end=0.5,
        step=0.005,
        **_SHORT,
    ),
}

SCENES = (
    {
        each.__name__: each()
        for each in (
            line_gimp,
            line_slows,
            line_mpm,
            plane_gimp,
            plane_mpm,
            space_gimp,
            space_mpm,
            narrow,
            line_leaves,
            plane_leaves,
            sinks,
            loaded,
            meeting,
            phased,
            staged,
            flowing,
            initial,
            exact_surfaces,
            exact_contact,
            exact_means,
            exact_round,
            exact_rings,
            exact_skins,
            initial_stages,
            initial_contact,
            surface_contact,
            surface_beside,
            surface_boxes,
            surface_stages,
            surface_blocks,
            surface_folded,
            surface_rings,
            surface_round,
            mixed_rings,
            mixed_round,
            mixed_flows,
            initial_lattice,
            averaged_lattice,
            averaged_contact,
            averaged_layers,
            averaged_grip,
            averaged_surfaces,
            both_configurations,
            damped,
            settled,
            quaking,
            dug,
            pressed,
            heavy,
            soaked,
            cut,
            metals,
            affine,
            varied,
            rings,
            rings_free,
            plates,
            plates_initial,
            rings_initial,
            rings_initial_contact,
            round_and_round,
            rigid_round,
            layer,
            endless,
            lifts,
            streams,
            pours,
            turned,
            passing,
        )
    }
    | SIZED
    | EXACT
    | {
        "other_output": plane_gimp(
            output={"every": {"steps": 7}, "at": [0.77], "fields": ["velocity"]},
            history={"every": 1.0},
        )
    }
)
#: Some have gauges besides.
SCENES |= {name: gauged(SCENES[name]) for name in GAUGED}
