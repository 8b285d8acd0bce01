"""The methods of the family, and how the figures show them."""

from typing import NamedTuple

from common import BLUE, GREEN, GREY, ORANGE, RED

PURPLE, BROWN, PINK = "#7b4fa3", "#8c5a2b", "#d6559b"


class Method(NamedTuple):
    """A method: its name in the figures, its entry in a case, its colour and marker."""

    label: str
    entry: str
    colour: str
    marker: str


#: "initial" and "tracked" are the volume in (16); the paper's MPM and GIMP keep the initial one.
METHODS = {
    "mpm": Method("MPM", "shape: mpm, volume: initial", RED, "^"),
    "gimp": Method("GIMP", "shape: gimp, volume: initial", BLUE, "o"),
    "finite-gimp": Method("Finite GIMP", "shape: finite-gimp", GREEN, "x"),
    "mpm-tracked": Method("MPM, volume tracked", "shape: mpm, volume: tracked", ORANGE, "v"),
    "gimp-tracked": Method("GIMP, volume tracked", "shape: gimp, volume: tracked", PURPLE, "s"),
    "fuzzy-nearest": Method("fuzzy-nearest", "shape: fuzzy-nearest", BROWN, "D"),
    "fuzzy-constant": Method("fuzzy-constant", "shape: fuzzy-constant", PINK, "p"),
    "fuzzy-nearest-fixed": Method(
        "fuzzy-nearest, size fixed, wall ghost", "shape: fuzzy-nearest, size: fixed, wall: ghost",
        ORANGE, "D",
    ),
    "fuzzy-constant-fixed": Method(
        "fuzzy-constant, size fixed, wall ghost", "shape: fuzzy-constant, size: fixed, wall: ghost",
        GREY, "p",
    ),
}  # fmt: skip
#: Columns of the figures that show the methods beside each other.
PAPER = ("mpm", "gimp", "finite-gimp")
TRACKED = ("mpm-tracked", "gimp-tracked")
FUZZY = ("fuzzy-nearest", "fuzzy-constant")
GHOSTS = ("fuzzy-nearest-fixed", "fuzzy-constant-fixed")
