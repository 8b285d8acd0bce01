"""Problems of `scripts/flows`: what each row of their table measures."""

from studies.flow import problems, sand

#: What is measured: its words, the reference, how it is computed, on which cells.
ROWS = (
    *(
        (words, reference, (problems.tube, "sod"), place, (0.005, 0.0025))
        for place, (words, reference) in enumerate((
            ("Sod's tube, cells of 1/200 and 1/400: p", 0.303130), ("the same: u", 0.927453),
            ("the same: density left of the surface", 0.426319),
            ("the same: density right of it", 0.265574), ("the same: speed of the shock", 1.752156),
        ))
    ),
    *(
        (words, reference, (problems.tube, "uintah"), place, (0.005, 0.0025))
        for place, (words, reference) in enumerate((
            ("Uintah's tube of air, ten to one, cells of 1/200 and 1/400: p [Pa]", 28858.3),
            ("the same: u [m/s]", 285.115), ("the same: density left of the surface", 0.479850),
            ("the same: density right of it", 0.240582),
            ("the same: speed of the shock [m/s]", 558.115),
        ))
    ),
    ("Newton's fluid in a channel of 10 and 20 cells: velocity over the exact", 1.0,
     (problems.channel, "newtonian"), 0, (0.01, 0.005)),
    ("Bingham's: velocity of the plug over the exact", 1.0,
     (problems.channel, "bingham"), 0, (0.01, 0.005)),
    ("the same: width of the plug over the exact", 1.0,
     (problems.channel, "bingham"), 1, (0.01, 0.005)),
    ("water at rest, 20 and 40 cells deep: error of p over the greatest", 0.0,
     (problems.hydrostatic,), 0, (0.01, 0.005)),
    ("a dam breaks, 30 and 60 cells deep: water at the far wall [s], after 0.416 (Ritter)", None,
     (problems.dam,), 0, (0.02, 0.01)),
    *(
        (words, 1.0, (problems.settled, wall), place, (0.04, 0.02))
        for words, wall, place in (
            ("that water at 8 to 10 s, wall: ghost, cells of 40 and 20 mm: pressure in the lowest "
             "quarter of a cell, over that of what is above", "ghost", 0),
            ("the same in the lowest cell", "ghost", 1),
            ("the same: force of the floor over the weight", "ghost", 2),
            ("the same with walls that reflect, in the lowest quarter", "mirror", 0),
            ("the same with walls that reflect, in the lowest cell", "mirror", 1),
        )
    ),
    ("a wave in water throws a plate, cells of 2 and 1 mm: its velocity over the exact", 1.0,
     (problems.blast,), 0, (0.002, 0.001)),
    ("column of sand, cells of 40 and 20 mm, drucker-prager: mean height (Tesserae.jl) [m]", 0.1184,
     (problems.column, "drucker-prager"), 0, (0.04, 0.02)),
    ("the same, mohr-coulomb", 0.1184, (problems.column, "mohr-coulomb"), 0, (0.04, 0.02)),
    *(
        (words, None, (sand.rest, relaxation), place, (0.04, 0.02))
        for words, relaxation, place in (
            ("that of mohr-coulomb at 2 s: kinetic energy over the greatest", "auto", 0),
            ("the same: mean distance from the middle [m]", "auto", 1),
            ("the same with pic-damping: 0: kinetic energy", 0.0, 0),
            ("the same with pic-damping: 0: mean distance from the middle [m]", 0.0, 1),
        )
    ),
    *(
        (words, reference, (sand.heap, *rest), place, (0.05, 0.025))
        for words, reference, place, *rest in (
            ("sand that rests at 31 degrees, a column as high as wide, 20 and 40 cells to its "
             "width: run-out over the width (Lube et al.)", 1.2, 0, 1),
            ("the same: J that particles track, of all", 1.0, 1, 1),
            ("the same: filling of a box in what has run out", 1.0, 2, 1),
            ("the same with volumetric: b-bar, run-out", 1.2, 0, 1, "mean"),
            ("the same: J with volumetric: b-bar", 1.0, 1, 1, "mean"),
            ("the same: filling with volumetric: b-bar", 1.0, 2, 1, "mean"),
            ("the same on a fixed floor: run-out", 1.2, 0, 1, "pointwise", "gimp", "fixed"),
            ("the same, cpdi", 1.2, 0, 1, "pointwise", "cpdi", "fixed"),
            ("the same, bspline-quadratic", 1.2, 0, 1, "pointwise", "bspline-quadratic", "fixed"),
            ("the same, three times as high as wide: run-out", 3.952, 0, 3),
            ("the same, three times as high as wide: filling", 1.0, 2, 3),
            ("the same with volumetric: b-bar, three times as high: run-out", 3.952, 0, 3, "mean"),
        )
    ),
    *(
        (words, 0.6, (sand.brake, *rest), 0, (0.1, 0.05))
        for words, *rest in (
            ("a layer of that sand slides on a floor of friction 0.6, 10 and 20 cells deep: "
             "deceleration over g", "gimp"),
            ("the same with bspline-quadratic", "bspline-quadratic"),
            ("the same on a fixed floor, gimp", "gimp", "fixed"),
            ("the same on a fixed floor, bspline-quadratic", "bspline-quadratic", "fixed"),
        )
    ),
    *(
        (words, 0.0, (sand.slide, *rest), 0, (1.0, 0.5))
        for words, *rest in (
            ("a ball of sand, 10 and 20 cells wide, falls apart on a rigid slope of 33 degrees, "
             "3D: part of its particles deeper in it than a quarter of a cell", "sand", "plane"),
            ("the same on a terrain of triangles", "sand", "terrain"),
            ("the same, water on the plane", "water", "plane"),
        )
    ),
    ("sand of 30 degrees on a smooth wall that recedes, 10 and 20 cells high: K_a", 1.0 / 3.0,
     (problems.rankine, 0.001), 0, (0.1, 0.05)),
    ("the same, a wall that advances: K_p", 3.0, (problems.rankine, -0.001), 0, (0.1, 0.05)),
    ("the same without dilation", 3.0, (problems.rankine, -0.001, 0.0), 0, (0.1, 0.05)),
    *(
        (words, reference, (sand.retained, volumetric), place, (0.1, 0.05))
        for words, reference, volumetric, place in (
            ("sand of 33 degrees on a rough base, a smooth wall recedes, volumetric: b-bar: K_a",
             0.294801, "mean", 0),
            ("the same: pressure within cells, rms over that of the height", 0.0, "mean", 1),
            ("the same without volumetric: b-bar: K_a", 0.294801, "pointwise", 0),
            ("the same without volumetric: b-bar: pressure within cells", 0.0, "pointwise", 1),
        )
    ),
    ("cam-clay compressed at constant volume, pgimp element, 100 and 200 steps: q over p before",
     0.689219, (problems.undrained, 2.0), 0, (100, 200)),
    ("strip on clay, 10 and 20 cells to half of it: N_c", 5.1416,
     (problems.footing, "mean"), 0, (0.1, 0.05)),
    ("the same without volumetric: b-bar, which locks", 5.1416,
     (problems.footing, "pointwise"), 0, (0.1, 0.05)),
    ("bank of clay, c = 13 kPa (stands above 10.4): settlement over height", None,
     (problems.bank, 13.0e3), 0, (0.2, 0.1)),
    ("the same, c = 7 kPa (falls)", None, (problems.bank, 7.0e3), 0, (0.2, 0.1)),
)  # fmt: skip
