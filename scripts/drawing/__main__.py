"""Draws the pictures that are named on the command line, or all."""

import argparse

from column import compaction
from cost import error_and_cost
from exact import shock, spinning_block, vortex
from flowing import blast, channel, dam_break, excavation, footing, gate, sand_column, slope, sod
from looking import block3d, block3d_initial, paraview
from meeting import corner, drum, hertz_impact, hertz_line
from metal import plate_impact, taylor_bar, thick_tube
from rolls import rolling, rolling_ball
from scenes import bar_vibration, disks, graded, incline, pile, upsetting

PICTURES = {
    "compaction": compaction,
    "block3d": block3d,
    "block3d-initial": block3d_initial,
    "block3d-paraview": paraview,
    "disks": disks,
    "rolling": rolling,
    "rolling-ball": rolling_ball,
    "incline": incline,
    "upsetting": upsetting,
    "pile": pile,
    "hertz": hertz_impact,
    "hertz-line": hertz_line,
    "corner": corner,
    "drum": drum,
    "bar-vibration": bar_vibration,
    "shock": shock,
    "plate-impact": plate_impact,
    "taylor-bar": taylor_bar,
    "thick-tube": thick_tube,
    "vortex": vortex,
    "spinning-block": spinning_block,
    "sod": sod,
    "channel": channel,
    "sand-column": sand_column,
    "slope": slope,
    "graded": graded,
    "excavation": excavation,
    "footing": footing,
    "dam-break": dam_break,
    "gate": gate,
    "blast": blast,
    "error-and-cost": error_and_cost,
}

parser = argparse.ArgumentParser(prog="scripts/pictures")
parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(PICTURES))
parser.add_argument("--redraw", action="store_true", help="draw from the runs that are there")
arguments = parser.parse_args()
unknown = sorted(set(arguments.names) - set(PICTURES))
if unknown:
    parser.error(f"there is no picture {unknown[0]}; there are {', '.join(PICTURES)}")
for name in arguments.names or PICTURES:
    PICTURES[name](arguments.redraw)
