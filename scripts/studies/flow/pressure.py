"""Measures the pressure on the far wall of the dam break, and draws it; see scripts/flows."""

import numpy as np
from drawing.common import BLUE, GREY, ORANGE, plt, save
from numpy.lib.stride_tricks import sliding_window_view
from studies.flow import problems
from studies.harness import Kept, Table, options_of, origin, out, put

#: Height of the column, the tank's length in whole cells of 0.04 m, and the column's volume.
H, LENGTH, VOLUME = 0.6, 3.24, 0.72
#: Pressure and time that others are divided by.
UNIT, CLOCK = 1000.0 * problems.G * H, np.sqrt(H / problems.G)
#: The gauge: a disk of 90 mm. Its middle is said to be at 0.16 m, where codes put its upper edge,
#: as that agrees better (Adami, Hu, Adams, J. Comput. Phys. 231, 2012).
GAUGE, STATED = (0.07, 0.16), (0.115, 0.205)
#: What B. Buchner measured there (thesis, Delft 2002): t sqrt(g/H) and p/(rho g H), some points
#: rounded to 0.02, read off by S. Marrone et al. (2011) and by the authors of TrixiParticles.jl.
MEASURED = (
    (2.42, 0.0), (2.5, 0.16), (2.62, 0.38), (2.68, 0.66), (2.78, 0.68), (3.0, 0.64), (3.2, 0.56),
    (3.6, 0.54), (4.2, 0.56), (4.8, 0.52), (5.2, 0.52), (5.5, 0.56), (5.7, 0.64), (5.82, 0.84),
    (5.94, 0.68), (6.1, 0.56), (6.28, 0.58), (6.5, 0.48), (6.8, 0.46), (7.2, 0.44),
)  # fmt: skip
#: While the jet climbs the wall, where Buchner has 0.54; the last period of what sloshes; the last
#: second.
JET, REST, STILL = (0.8, 1.3), (5.55, 9.95), (8.95, 9.95)
#: The running mean that noise is counted from, and the step of what is resampled.
MEAN, FINE = 0.05, 5.0e-4
_THICK = {"linear": 0.5, "quadratic": 0.0}
#: What is measured: its words, the cell, changes of the case.
ROWS = (
    *(
        (words, cell, changes)
        for words, changes in (
            ("as it is", {}), ("`affine: true`", {"method.affine": True}),
            ("3 x 3 particles a cell", {"method.particles-per-cell": [3, 3]}),
            ("`viscosity: {linear: 0.5, quadratic: 0.0}`", {"materials.water.viscosity": _THICK}),
        ) for cell in (0.04, 0.02)
    ),
    ("`bulk: 1.5e+5`, half the speed of sound", 0.04, {"materials.water.bulk": 1.5e5}),
    ("`bulk: 2.4e+6`, twice the speed of sound", 0.04, {"materials.water.bulk": 2.4e6}),
)  # fmt: skip


def on(particles, near, patch, cell):
    """Mean pressure on a patch of the wall, of particles within a cell of it; what is void has 0.

    `near` are those within a cell of the wall, `patch` its lower and upper edge.
    """
    y = particles["position"][near, 1]
    rows = near[(y > patch[0]) & (y < patch[1])]
    force = np.dot(particles["pressure"][rows], particles["volume"][rows])
    return force / (cell * (patch[1] - patch[0]))


def record(cell, changes):
    """Time, both gauges, force, depth at the wall, kinetic energy every few steps; speed."""
    lines = []
    deep = 0.12  # width of the strip in which the depth is measured

    def look(sim):
        particles = sim.particles
        x = particles["position"][:, 0]
        near = np.flatnonzero(x > LENGTH - cell)
        depth = particles["mass"][x > LENGTH - deep].sum() / (1000.0 * deep)
        force = -sim.diagnostics()["reaction.x-max-x"]
        gauges = [on(particles, near, patch, cell) for patch in (GAUGE, STATED)]
        lines.append([sim.time, *gauges, force, depth])

    tank = {"grid.cell": [cell, cell], "grid.size": [LENGTH, 2.4], "time.end": 10.0}
    sim, speed = problems.done("dam-break", look, 4, **tank | problems.PLAIN | changes)
    return np.array(lines), sim.steps, speed


def smooth(time, values):
    """Times FINE apart, the values there, and their running mean over MEAN."""
    half = round(0.5 * MEAN / FINE)
    t = np.arange(0.0, time[-1], FINE)
    raw = np.interp(t, time, values)
    mean = sliding_window_view(raw, 2 * half + 1).mean(axis=1)
    return t[half:-half], raw[half:-half], mean


def over(time, values, when):
    """Mean, rms of what differs from the running mean, and greatest value over some time."""
    t, raw, mean = smooth(time, values)
    there = (t >= when[0]) & (t < when[1])
    noise = np.sqrt(np.mean((raw - mean)[there] ** 2))
    return float(mean[there].mean()), float(noise), float(raw[there].max())


def spectrum(time, values):
    """Frequencies, and the variance from the running mean up to each over all, under the jet."""
    t, raw, mean = smooth(time, values)
    there = (t >= JET[0]) & (t < JET[1])
    off = (raw - mean)[there]
    power = np.cumsum(np.abs(np.fft.rfft(off * np.hanning(len(off)))) ** 2)
    return np.fft.rfftfreq(len(off), FINE), power / power[-1]


def figures(lines):
    time, gauge, stated, force, depth = lines.T
    t, raw, mean = smooth(time, gauge)
    first, back = t < 0.5 * (JET[0] + JET[1]), (t > 1.3) & (t < 1.9)
    jet, rest = over(time, gauge, JET), over(time, gauge, REST)
    whole = over(time, force, JET)
    deep, _, _ = over(time, depth, REST)
    frequency, part = spectrum(time, gauge)
    tone, below = spectrum(time, force)
    hydrostatic = 1000.0 * problems.G * (deep - 0.5 * sum(GAUGE))
    return {
        "front": float(time[np.flatnonzero(force > 20.0)[0]]),
        "jet": jet[0] / UNIT, "stated": over(time, stated, JET)[0] / UNIT, "noise": jet[1] / UNIT,
        "fast": 1.0 - float(np.interp(120.0, frequency, part)),
        "force": whole[1] / whole[0], "tone": float(np.interp(0.5, below, tone)),
        "impact": float(raw[first].max()) / UNIT,
        "back": float(mean[back].max()) / UNIT, "when": float(t[back][mean[back].argmax()]),
        "rest": rest[0] / hydrostatic - 1.0, "still": over(time, gauge, STILL)[1] / UNIT,
    }  # fmt: skip


def draw(runs):
    """Write cases/pictures/dam-break-pressure.png: the gauge and the force, on both cell sizes."""
    figure, axes = plt.subplots(2, 1, figsize=(9, 6.4), sharex=True)
    for (cell, lines), colour in zip(runs, (ORANGE, BLUE), strict=True):
        for axis, column, unit in ((axes[0], 1, UNIT), (axes[1], 3, 1.0)):
            t, raw, mean = smooth(lines[:, 0], lines[:, column])
            axis.plot(t, raw / unit, color=colour, lw=0.5, alpha=0.45)
            label = f"cells of {1e3 * cell:.0f} mm, mean over {MEAN:g} s"
            axis.plot(t, mean / unit, color=colour, lw=1.6, label=label)
    measured = np.array(MEASURED)
    axes[0].plot(measured[:, 0] * CLOCK, measured[:, 1], "ko", ms=3.5, label="measured (Buchner)")
    level = VOLUME / LENGTH
    rest = (level - 0.5 * sum(GAUGE)) / H, 500.0 * problems.G * level**2
    for axis, value in zip(axes, rest, strict=True):
        axis.axhline(value, color=GREY, ls="--", lw=1.0, label="at rest in the end")
    arrival = (LENGTH - 1.2) / (2.0 * np.sqrt(problems.G * H))
    axes[0].axvline(arrival, color=GREY, ls=":", lw=1.0, label="front of Ritter")
    axes[0].set(ylabel="p/(rho g H) at 0.07 to 0.16 m", ylim=(-0.05, 2.0), xlim=(0.3, 3.0))
    axes[1].set(xlabel="time [s]", ylabel="force of the far wall [N/m]", ylim=(-100.0, 4000.0))
    axes[0].legend(loc="upper right")
    save(figure, "dam-break-pressure")


def row(words, cell, f, steps, speed):
    return (
        words, f"{1e3 * cell:.0f}", f"{f['front']:.3f}", f"{f['impact']:.1f}",
        f"{f['jet']:.2f}", f"{f['noise']:.2f}", f"{100.0 * f['fast']:.0f} %",
        f"{100.0 * f['force']:.0f} %, {f['tone']:.0f} Hz", f"{f['back']:.2f} at {f['when']:.2f} s",
        f"{100.0 * f['rest']:+.1f} %", f"{f['still']:.3f}", f"{steps:,}", f"{speed / 1e6:.1f}",
    )  # fmt: skip


def main():
    """Measure, and write flows.out/pressure.md, the picture and docs/soils-and-fluids.md."""
    new = options_of("flows pressure", new="measure all of it again").new
    kept = Kept(out("flows") / "pressure.json", new)
    table = Table(
        "dam-break", "cells [mm]", "front at the wall [s]", "first peak", "under the jet", "noise",
        "of it above 120 Hz", "noise of the force, half of it below", "second peak, of the mean",
        "error near rest", "noise near rest", "steps", "million particle-steps/s",
    )  # fmt: skip
    shown = []
    for number, (words, cell, changes) in enumerate(ROWS):
        key, series = f"{words} {cell}", out("flows") / f"pressure-{number}.npy"
        if key not in kept or not series.exists():
            found, steps, speed = record(cell, changes)
            np.save(series, found)
            kept.add(key, (steps, speed))
        found = np.load(series)
        if not changes:
            shown.append((cell, found))
        table.add(*row(words, cell, figures(found), *kept[key]))
    draw(shown)
    text = table.text(f"By `scripts/flows pressure`: {origin()}.")
    put({"pressure": text}, out("flows") / "pressure.md")
