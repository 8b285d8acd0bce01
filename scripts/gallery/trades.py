"""The trade of each case: the sections of the gallery, and the order within them."""

TRADES = {
    "Solids and impact": (
        "block3d", "disks", "rolling", "rolling-ball", "incline", "upsetting", "pile",
        "hopkinson", "hertz", "hertz-line", "brake-pad", "corner", "bar-vibration", "tube", "shock",
        "own/spinning-disk", "geometry/nut",
    ),
    "Metals": ("taylor-bar", "taylor-axisymmetric", "plate-impact", "thick-tube"),
    "Soils": (
        "excavation", "slope", "safety", "footing", "cavity", "cone", "tunnel", "shaking",
        "shaken-slope", "sand-column", "graded",
    ),
    "Fluids and grains": (
        "dam-break", "gate", "jet", "hopper", "channel", "poiseuille", "bagnold", "blast", "sod",
        "drum", "fluid/dam-break", "own/taylor-green",
    ),
    "Methods": (
        "compaction", "vortex", "spinning-block", "plane-waves", "own/swirl", "hard/translation",
        "hard/column", "hard/shock", "hard/spinning", "hard/stretch", "hard/bending",
        "hard/grazing", "hard/blocks",
    ),
}  # fmt: skip
