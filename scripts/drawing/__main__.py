"""Draws the pictures that are named on the command line, or all."""

import argparse

from column import compaction
from cost import error_and_cost
from curves import (
    bagnold,
    cavity,
    own_spinning_disk,
    own_taylor_green,
    poiseuille,
    shaken_slope,
    shaking,
    tunnel,
)
from exact import plane_waves, shock, spinning_block, vortex
from flowing import (
    blast,
    channel,
    dam_break,
    excavation,
    footing,
    gate,
    hopper,
    jet,
    safety,
    sand_column,
    slope,
    sod,
)
from hard import (
    fluid_dam_break,
    hard_bending,
    hard_column,
    hard_grazing,
    hard_shock,
    hard_spinning,
    hard_translation,
    nut,
    own_swirl,
)
from lessons import (
    tutorial_dam_break,
    tutorial_footing,
    tutorial_hopkinson,
    tutorial_impact,
    tutorial_own_material,
)
from looking import block3d, block3d_initial, block3d_paraview
from meeting import brake_pad, corner, drum, hertz, hertz_line
from metal import plate_impact, taylor_bar, thick_tube
from rings import cone, revolved_disk, taylor_axisymmetric, taylor_contours, tube
from rolls import rolling, rolling_ball
from scenes import bar_vibration, disks, graded, hopkinson, incline, pile, upsetting
from studies.harness import chosen

PICTURES = {function.__name__.replace("_", "-"): function for function in (
    compaction, block3d, block3d_initial, block3d_paraview, disks, rolling, brake_pad,
    rolling_ball, incline, upsetting, pile, hopkinson, hertz, hertz_line, corner, drum,
    bar_vibration, shock, plate_impact,
    taylor_bar, taylor_axisymmetric, taylor_contours, thick_tube, tube, vortex, spinning_block,
    plane_waves, sod, channel, poiseuille, bagnold, sand_column, slope, graded, excavation, safety,
    footing, cavity, cone, tunnel, shaking, shaken_slope, dam_break, jet, hopper, gate, blast, nut,
    fluid_dam_break, own_swirl, own_taylor_green, own_spinning_disk, revolved_disk,
    hard_translation, hard_column, hard_shock, hard_spinning, hard_bending, hard_grazing,
    tutorial_footing, tutorial_impact, tutorial_dam_break, tutorial_hopkinson,
    tutorial_own_material, error_and_cost,
)}  # fmt: skip
parser = argparse.ArgumentParser(prog="scripts/pictures")
parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(PICTURES))
parser.add_argument("--redraw", action="store_true", help="draw from the runs that are there")
arguments = parser.parse_args()
for name in chosen(parser, arguments.names, PICTURES, "picture ") or PICTURES:
    PICTURES[name](arguments.redraw)
