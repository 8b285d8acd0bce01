"""One mistake each in a good case, and what the message must say about it."""

GOOD = """\
format: 1
title: Two bodies
units: none
dimensions: 2
grid: {origin: [0.0, 0.0], size: [10.0, 6.0], cell: [0.5, 0.5]}
method: {shape: gimp, particles_per_cell: [2, 2]}
time:
  end: 1.0
  step: 0.001
materials:
  steel:
    model: hooke
    young: 1.0e6
    poisson: 0.3
    density: 1.0
bodies:
  left:
    material: steel
    region: {ball: {centre: [2.0, 3.0], radius: 1.0}}
    velocity: [1.0, 0.0]
  right:
    material: steel
    region: {box: {min: [6.0, 2.0], max: [8.0, 4.0]}}
    velocity: {rotation: {about: [7.0, 3.0], rate: 2.0}}
gravity: {table: [[0.0, [0.0, 0.0]], [1.0, [0.0, -9.81]]]}
boundaries:
  x-min: fixed
  y-min: {velocity: [0.0, {table: [[0.0, 0.0], [1.0, 2.0]]}]}
output: {every: 0.1, at: [0.55], fields: [stress]}
history: {every: {steps: 10}}
"""

BALL = "{ball: {centre: [2.0, 3.0], radius: 1.0}}"

# What is replaced in the good case, by what, the line and key path, and parts of the message.
MISTAKES = [
    # Keys
    ("young:", "yuong:", "13: materials.steel.yuong", "unknown key; did you mean 'young'?"),
    ("young:", "yuong:", "13: materials.steel.yuong", "density, model, poisson, viscosity,"),
    ("units:", "unit:", "3: unit", "did you mean 'units'?"),
    ("history:", "probes: {}\nhistory:", "30: probes", "unknown key; allowed: bodies,"),
    ("output:", "checkpoints: {}\noutput:", "29: checkpoints", "did you mean 'checkpoint'?"),
    ("Two bodies", '"two\\nlines"', "2: title", "expected a line of text", "U+000A"),
    ("Two bodies", '"\\e[2J"', "2: title", "expected a line of text", "U+001B"),
    ("Two bodies", "x" * 1001, "2: title", "expected at most 1000 characters, got 1,001"),
    ("  left:", f"  {'l' * 101}:", f"17: bodies.{'l' * 57}...: a name starts with a letter"),
    ("title:", '"a\\nb\\e[2J":', "2: a b [2J", "unknown key"),
    ("fields: [stress]", "grid: []", "29: output.grid", "unknown key", "fields, precision"),
    ("poisson: 0.3", "poisson: 0.3\n    c1: 1", "15: materials.steel.c1", "unknown key"),
    ("cell: [0.5, 0.5]", "cell:0.5", "5: grid.cell:0.5", "a space is missing", "'cell: 0.5'"),
    ("{steps: 10}", "{steps:10}", "30: history.every.steps:10", "a space is missing"),
    ("    density: 1.0\n", "", "11: materials.steel.density", "missing (initial density"),
    ("    model: hooke\n", "", "11: materials.steel.model", "missing", "known models: hooke"),
    ("shape: gimp, ", "", "6: method.shape", "missing; known shapes: finite-gimp,"),
    ("format: 1\n", "", " format", "missing (version of the case file's format)"),
    ("end: 1.0", "end: 1.0\n  stop: 1.0", "9: time.stop", "unknown key", "allowed: end, step"),
    ("title: Two bodies", "time: {end: 1.0}", "7: time", "there already, in line 2"),
    ("poisson: 0.3", "young: 1", "14: materials.steel.young", "there already, in line 13"),
    ("x-min: fixed", "x-min: fixed\n  x-min: slip", "28: boundaries.x-min", "in line 27"),
    ("  left:", "  left.one:", "17: bodies.left.one", "a name starts with a letter"),
    ("  left:", "  ligné:", "17: bodies.ligné", "a name starts with a letter"),
    # Types
    ("1.0e6", '"1.0e6"', "13: materials.steel.young", "got the text '1.0e6'", "without quotes"),
    ("1.0e6", "1_000_000", "13: materials.steel.young", "write the number as 1000000,"),
    ("1.0e6", "1.0d6", "13: materials.steel.young", "write the number as 1.0e6,"),
    ("1.0e6", "true", "13: materials.steel.young", "expected a number, got true"),
    ("1.0e6", "[1.0e6]", "13: materials.steel.young", "expected a number, got a list of 1"),
    ("1.0e6", "", "13: materials.steel.young", "expected a number, got nothing"),
    ("1.0e6", ".nan", "13: materials.steel.young", "expected a finite number, got nan"),
    ("1.0e6", "-.inf", "13: materials.steel.young", "expected a finite number, got -inf"),
    ("1.0e6", "1e999", "13: materials.steel.young", "expected a finite number"),
    ("1.0e6", "9" * 5000, "13: materials.steel.young", "expected a finite number"),
    ("1.0e6", "9" * 350, "13: materials.steel.young", "expected a number, got a huge number"),
    ("1.0e6", "{a: 1}", "13: materials.steel.young", "expected a number, got a mapping"),
    ("1.0e6", "10 GPa", "13: materials.steel.young", "expected a number, got the text '10 GPa'"),
    ("Two bodies", "2", "2: title", "expected text, got 2", "needs quotes"),
    ("Two bodies", "[a, b]", "2: title", "expected text, got a list of 2"),
    ("material: steel\n    region: {ball", "material: 3\n    region: {ball",
     "18: bodies.left.material", "expected text, got 3"),
    ("[2, 2]", "[2, 2.5]", "6: method.particles_per_cell.1", "expected a whole number, got 2.5"),
    ("[2, 2]", "[2, yes]", "6: method.particles_per_cell.1", "expected a whole number"),
    ("[2, 2]", "4", "6: method.particles_per_cell", "expected a list, got 4"),
    ("grid: {origin: [0.0, 0.0], size: [10.0, 6.0], cell: [0.5, 0.5]}", "grid: 3",
     "5: grid", "expected a mapping of keys to values, got 3"),
    ("  end: 1.0\n  step: 0.001", "  - 1", "7: time", "expected a mapping", "got a list of 1"),
    ("  end: 1.0\n  step: 0.001", "  end:1.0", "7: time", "a space is missing", "'end: 1.0'"),
    ("{every: 0.1, at: [0.55], fields: [stress]}", "", "29: output", "got nothing"),
    # Values
    ("format: 1", "format: 2", "1: format", "this pgimp reads format 1, got 2"),
    ("format: 1", "format: 0", "1: format", "must be at least 1, got 0"),
    ("dimensions: 2", "dimensions: 4", "4: dimensions", "expected 1, 2 (plane strain) or 3, got 4"),
    ("1.0e6", "0", "13: materials.steel.young", "must be above 0, got 0"),
    ("1.0e6", "-2", "13: materials.steel.young", "must be above 0, got -2"),
    ("poisson: 0.3", "poisson: 0.5", "14: materials.steel.poisson", "must be below 0.5, got 0.5"),
    ("poisson: 0.3", "poisson: -1", "14: materials.steel.poisson", "must be above -1, got -1"),
    ("[2, 2]", "[2, 0]", "6: method.particles_per_cell.1", "must be at least 1, got 0"),
    ("model: hooke", "model: hook", "12: materials.steel.model", "did you mean 'hooke'?"),
    ("model: hooke", "model: linear-1d", "14: materials.steel.poisson", "unknown key"),
    ("model: hooke", "model: [hooke]", "12: materials.steel.model", "expected the name of a model"),
    ("shape: gimp", "shape: cpdi", "6: method.shape", "unknown shape 'cpdi'"),
    ("gimp,", "gimp, volume: fixed,", "6: method.volume", "unknown value 'fixed'", "tracked"),
    ("step: 0.001", "step: {courant: 1.5}", "9: time.step.courant", "must be at most 1, got 1.5"),
    ("step: 0.001", "step: {courant: 0}", "9: time.step.courant", "must be above 0, got 0"),
    ("step: 0.001", "step: auto", "9: time.step", "{courant: 0.3}, got the text 'auto'"),
    ("step: 0.001", "step: 0.0", "9: time.step", "must be above 0, got 0"),
    ("step: 0.001", "step: 1e-300", "9: time.step", "1e+300 steps are too many"),
    ("end: 1.0", "end: 1.0004", "8: time.end", "(1000.4 steps); the nearest is 1"),
    ("end: 1.0", "end: 1.0006", "8: time.end", "(1000.6 steps); the nearest is 1.001"),
    ("{steps: 10}", "{steps: 0}", "30: history.every.steps", "must be at least 1, got 0"),
    ("{steps: 10}", "{steps: 1.5}", "30: history.every.steps", "a whole number, got 1.5"),
    ("{steps: 10}", "{steps: 10, wall: 1}", "30: history.every.wall", "allowed: steps"),
    ("every: 0.1", "every: 0", "29: output.every", "must be above 0, got 0"),
    ("every: 0.1", "every: often", "29: output.every", "a time above zero or {steps: 10}"),
    ("[0.55]", "[0.5, 2.0]", "29: output.at.1", "2 is after the end at 1"),
    ("[0.55]", "[-0.5]", "29: output.at.0", "must be at least 0, got -0.5"),
    ("[stress]", "[stres]", "29: output.fields.0", "unknown field 'stres'; did you mean 'stress'?"),
    ("[stress]", "[temperature]", "29: output.fields.0", "displacement, pressure, stress"),
    ("[stress]", "[stress, stress]", "29: output.fields.1", "stress is in the list already"),
    ("[stress]}", "[stress], precision: float16}", "29: output.precision", "did you mean 'float"),
    ("[stress]}", "[stress], precision: 32}", "29: output.precision", "'float32', got 32"),
    ("[stress]}", "[stress], compression: lz4}", "29: output.compression", "known: gzip, none"),
    ("[stress]}", "[stress], compression: true}", "29: output.compression", "'gzip', got true"),
    # Dimensions and grid
    ("cell: [0.5, 0.5]", "cell: [0.5]", "5: grid.cell", "expected 2 entries", "got a list of 1"),
    ("origin: [0.0, 0.0]", "origin: []", "5: grid.origin", "expected at least 1 entry"),
    ("[10.0, 6.0]", "[10.0, 6.0, 1.0]", "5: grid.size", "expected 2 entries, one a direction"),
    ("[10.0, 6.0]", "[10.0, 6.2]", "5: grid.size.1", "6.2 is not a whole number of cells of 0.5",
     "(12.4 cells); the nearest is 6"),
    ("cell: [0.5, 0.5]", "cell: [0.3, 0.5]", "5: grid.size.0", "the nearest is 9.9"),
    ("cell: [0.5, 0.5]", "cell: [1e-8, 0.5]", "5: grid.cell.0", "1e+09 cells are too many"),
    ("cell: [0.5, 0.5]", "cell: [1e-320, 0.5]", "5: grid.cell.0", "cells are too many"),
    ("origin: [0.0, 0.0]", "origin: [1e18, 0.0]", "5: grid.origin.0", "cannot resolve cells"),
    ("size: [10.0, 6.0], ", "", "5: grid.size", "missing (extent of the domain"),
    ("[2, 2]", "[2]", "6: method.particles_per_cell", "expected 2 entries", "got a list of 1"),
    # Bodies
    ("material: steel\n    region: {box", "material: steal\n    region: {box",
     "22: bodies.right.material", "unknown material 'steal'; did you mean 'steel'? known: steel"),
    (BALL, "{sphere: {radius: 1}}", "19: bodies.left.region.sphere", "unknown region 'sphere'",
     "ball, box, cylinder"),
    (BALL, "{}", "19: bodies.left.region", "expected a region", "got {}"),
    (BALL, "ball", "19: bodies.left.region", "expected a region", "got the text 'ball'"),
    (BALL, "{box: {min: [1, 1], max: [2, 2]}, ball: {}}", "19: bodies.left.region",
     "expected exactly one of box, ball"),
    (BALL, "{box: {min: [1, 2], max: [2, 2]}}", "19: bodies.left.region.box.max.1",
     "must be above min, 2, got 2"),
    (BALL, "{box: {min: [1], max: [2, 2]}}", "19: bodies.left.region.box.max", "entries as in min"),
    (BALL, "{ball: {centre: [1, 1, 1], radius: 1}}", "19: bodies.left.region.ball.centre",
     "expected 2 entries"),
    (BALL, "{ball: {center: [1, 1], radius: 1}}", "19: bodies.left.region.ball.center",
     "did you mean 'centre'?"),
    (BALL, "{ball: {centre: [1, 1], radius: -1}}", "19: bodies.left.region.ball.radius",
     "must be above 0, got -1"),
    (BALL, "{cylinder: {from: [1, 1, 0], to: [1, 1, 1], radius: 1}}",
     "19: bodies.left.region.cylinder", "exists in 3D only; in 2D a disk is a ball"),
    (BALL, "{cylinder: {from: [1, 1, 0], to: [1, 1, 0], radius: 1}}",
     "19: bodies.left.region.cylinder.to", "the same point as from"),
    (BALL, f"{{union: [{BALL}]}}", "19: bodies.left.region.union", "expected at least 2 entries"),
    (BALL, f"{{union: [{BALL}, {{bal: 1}}]}}", "19: bodies.left.region.union.1.bal", "'ball'?"),
    (BALL, f"{{union: [{BALL}, {{ball: {{centre: [1], radius: 1}}}}]}}",
     "19: bodies.left.region.union.1.ball.centre", "expected 2 entries"),
    (BALL, f"{{difference: {BALL}}}", "19: bodies.left.region.difference", "expected a list"),
    ("centre: [2.0, 3.0]", "centre: [0.5, 3.0]", "19: bodies.left.region",
     "reaches 0.5 beyond the domain at x-min: to -0.5, where the domain ends at 0"),
    ("max: [8.0, 4.0]", "max: [8.0, 6.25]", "23: bodies.right.region",
     "reaches 0.25 beyond the domain at y-max: to 6.25, where the domain ends at 6"),
    ("velocity: [1.0, 0.0]", "velocity: [1.0]", "20: bodies.left.velocity", "expected 2 entries"),
    ("velocity: [1.0, 0.0]", "velocity: 1.0", "20: bodies.left.velocity", "{rotation: ...}, got 1"),
    ("velocity: [1.0, 0.0]", "velocity: [1.0, x]", "20: bodies.left.velocity.1", "the text 'x'"),
    ("rate: 2.0", "rate: [0, 0, 2.0]", "24: bodies.right.velocity.rotation.rate",
     "expected a number in 2D, got a list of 3"),
    ("rate: 2.0", "rate: x", "24: bodies.right.velocity.rotation.rate", "got the text 'x'"),
    ("about: [7.0, 3.0]", "about: [7.0]", "24: bodies.right.velocity.rotation.about", "2 entries"),
    ("about: [7.0, 3.0], ", "", "24: bodies.right.velocity.rotation.about", "missing (a point of"),
    # Gravity and boundaries
    ("[1.0, [0.0, -9.81]]", "[1.0, [-9.81]]", "25: gravity.table.1.1", "expected 2 values"),
    ("[1.0, [0.0, -9.81]]", "[0.0, [0.0, -9.81]]", "25: gravity.table.1.0", "must increase"),
    ("[1.0, [0.0, -9.81]]", "[1.0, -9.81]", "25: gravity.table.1.1", "expected a list, got -9.81"),
    ("[1.0, [0.0, -9.81]]", "[1.0]", "25: gravity.table.1.1", "missing"),
    ("{table: [[0.0, [0.0, 0.0]], [1.0, [0.0, -9.81]]]}", "{table: []}", "25: gravity.table",
     "expected at least 1 entry, got an empty list"),
    ("{table: [[0.0, [0.0, 0.0]], [1.0, [0.0, -9.81]]]}", "-9.81", "25: gravity",
     "one number a direction or {table"),
    ("{table: [[0.0, [0.0, 0.0]], [1.0, [0.0, -9.81]]]}", "[0, 0, -9.81]", "25: gravity",
     "expected 2 entries, one a direction, got a list of 3"),
    ("x-min: fixed", "z-min: fixed", "27: boundaries.z-min", "unknown face 'z-min'", "x-max, "),
    ("x-min: fixed", "left: fixed", "27: boundaries.left", "unknown face 'left'"),
    ("x-min: fixed", "x-min: fix", "27: boundaries.x-min", "did you mean 'fixed'?"),
    ("x-min: fixed", "x-min: open", "27: boundaries.x-min", "known: fixed, separating, slip"),
    ("x-min: fixed", "x-min: velocity", "27: boundaries.x-min", "expected {velocity: ...}"),
    ("x-min: fixed", "x-min: {fixed: true}", "27: boundaries.x-min", "the plain word 'fixed'"),
    ("x-min: fixed", "x-min: {traction: 1}", "27: boundaries.x-min.traction", "unknown boundary"),
    ("x-min: fixed", "x-min: 0", "27: boundaries.x-min", "one of fixed, slip, separating"),
    ("x-min: fixed", "x-min: {velocity: [0]}", "27: boundaries.x-min.velocity", "2 entries"),
    ("x-min: fixed", "x-min: {velocity: [0, a]}", "27: boundaries.x-min.velocity.1", "text 'a'"),
    ("[1.0, 2.0]]", "[0.0, 2.0]]", "28: boundaries.y-min.velocity.1.table.1.0", "must increase"),
    ("[1.0, 2.0]]", "[1e-300, 1e300]]", "28: boundaries.y-min.velocity.1.table.1", "too large"),
    ("{table: [[0.0, 0.0], ", "{tabel: [[0.0, 0.0], ", "28: boundaries.y-min.velocity.1.tabel",
     "did you mean 'table'?"),
    ("output:", "escape: {y-min: remove}\noutput:", "29: escape.y-min", "y-min has a condition"),
    ("output:", "escape: {z-max: remove}\noutput:", "29: escape.z-max", "unknown face 'z-max'"),
    ("output:", "escape: {x-max: go}\noutput:", "29: escape.x-max", "unknown value 'go'; known: "),
    ("output:", "escape: x-max\noutput:", "29: escape", "expected a mapping of keys to values"),
    # YAML
    ("  end: 1.0", "\tend: 1.0", "8:1", "a tab; indent with spaces only"),
    ("  end: 1.0", "   end: 1.0", "9:3", "the indentation does not fit"),
    ("  end: 1.0", "  end:1.0", "9:7", "a space is missing after the colon of 'end:' in line 8"),
    ("Two bodies", "Two: bodies", "2:11", "text with a colon needs quotes"),
    ("Two bodies", "'Two bodies", "31:1", "the quote that opens in line 2 is not closed"),
    ("Two bodies", "%two", "2:8", "text that starts with '%' needs quotes"),
    ("Two bodies", "*two", "2:8", "no anchors and aliases"),
    ("Two bodies", "&two bodies", "2:8", "no anchors and aliases"),
    ("Two bodies", "!!str two", "2:8", "no tags"),
    ("Two bodies", "!!python/object:os.system two", "2:8", "no tags"),
    ("Two bodies", "- two", "2:8", "a list item cannot start here"),
    ("Two bodies", "'two' bodies", "2:14", "does not belong here"),
    ("units: none", "---", "3:1", "one document"),
    ("units: none", "<<: {a: 1}", "3: <<", "unknown key"),
    ("units: none", "? [a]\n: b", "3:3", "a key is a plain word before a colon"),
    ("units: none", ": none", "3:1", "a key is a plain word before a colon"),
    ("[stress]}", "[stress}", "29:", "the closing ']' is missing"),
    ("{steps: 10}}", "{steps: 10}", "31:1", "the closing '}' is missing"),
    ("Two bodies", "two \x07 bodies", "2", "U+0007 does not belong in a text file"),
    ("Two bodies", "[" * 100_000, "2:", "nested deeper than 32 levels"),
]  # fmt: skip
