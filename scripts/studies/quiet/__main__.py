"""Measures faces without ends and ground at rest; see scripts/quiet."""

from studies.harness import options_of, origin, table
from studies.quiet import ground, jet, long, oblique, settle, shaken


def main():
    """Measure what is asked for, and write its tables."""
    what = {
        "nargs": "*",
        "among": ("oblique", "shaken", "ground", "settle", "jet", "long"),
        "metavar": "WHAT",
    }
    options = options_of("quiet", what=what, steps={"type": int, "default": 100_000})
    chosen = options.what or what["among"]
    measured = f"Measured by `scripts/quiet` on one core of {origin()}."
    if "oblique" in chosen:
        titles = ["angle from the normal", *(f"{angle}°" for angle in oblique.ANGLES)]
        rows = []
        for wave in oblique.SPEED:
            found = {wave: oblique.returned(wave), f"{wave}, plane waves": oblique.plane(wave)}
            rows += [[name, *(f"{part:.2f}" for part in parts)] for name, parts in found.items()]
        print(table(titles, rows, measured))
    if "shaken" in chosen:
        titles = ["place", "by elements", "lag [rad]", "cells of 2 m", "cells of 1 m"]
        print(table(titles, shaken.slope_rows(), measured))
        away = [f"{distance} H away" for distance in shaken.AWAY]
        titles = ["frequency over H's own", "level ground without sides", *away]
        print(table(titles, shaken.side_rows(), measured))
    if "ground" in chosen:
        rows = [
            [name, "; ".join(f"{ground.unrest(case(), 1000):.0e}" for case in cases)]
            for name, cases in ground.SCENES.items()
        ]
        titles = (
            "ground, 4 to 7 cells high, after 1,000 steps",
            "largest velocity over the wave speed",
        )
        print(table(titles, rows, measured))
    if "settle" in chosen:
        courants = [f"`current`, {courant}" for courant in settle.COURANTS]
        titles = ["scene", "", "highest frequency over the lowest", "`initial`", *courants,
                  "error of the ways"]  # fmt: skip
        print(table(titles, [row for name in settle.SCENES for row in settle.rows(name)], measured))
    if "jet" in chosen:
        rows = [[2 * k, *jet.plate(0.025 / k)] for k in (1, 2, 4)]
        titles = ["cells across half the jet", "mean force", "swings by", "steps",
                  "particles at the end", "time"]  # fmt: skip
        print(table(titles, rows, measured))
    if "long" in chosen:
        steps = options.steps
        rows = [
            [name, f"largest velocity over the wave speed {ground.unrest(case, steps):.0e}"]
            for name, case in long.rests().items()
        ]
        momentum, turns = long.rounds(steps)
        said = f"momentum to {momentum:.0e} of itself, {turns:.0f} turns"
        rows.append(["two blocks that meet between periodic faces", said])
        lost, speed = long.channel(steps)
        said = f"mass to {lost:.0e}, mean speed {speed:.2f} of the inflow's"
        rows.append(["a channel that is fed and empties", said])
        for configuration in ("initial", "current"):
            said = f"energy of the last tenth {long.ring(configuration, steps):.4f} of the first"
            rows.append([f"a tube that breathes, `{configuration}`", said])
        print(table(["scene", f"in {steps:,} steps"], rows, measured))
