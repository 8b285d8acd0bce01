"""Whole steps: particle-steps/s by dimension, shape, material, positions, particles per cell."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from blocks import MATERIALS, PHASES, Timed, block, create
from picture import plt, save
from report import ERRORS, count, number, origin, spread, write

from pgimp.physics.shapes import SHAPES
from pgimp.solver.simulation import RESORT

SIZES = {1: (65_536,), 2: (224, 224), 3: (24, 24, 24)}
SMALL = {1: (64,), 2: (8, 8), 3: (4, 4, 4)}


def scenes(quick):
    """What is measured: (dimension, shape, material, particles per cell, random)."""
    found = []
    for D in (2,) if quick else (3, 2, 1):
        material = "linear-1d" if D == 1 else "neo-hookean"
        for shape in ("gimp", "mpm") if quick else SHAPES:
            found += [(D, shape, material, 2, random) for random in (False, True)]
        if quick:
            continue
        others = [name for name in MATERIALS if (name == "linear-1d") == (D == 1)]
        found += [(D, "gimp", name, 2, True) for name in others if name != material]
        found += [(D, "gimp", material, n, True) for n in (1, 3, 4)]
    return found


def case_of(scene, sizes):
    """The case of a scene; with another number of particles per cell as many particles, about."""
    D, shape, material, per_cell, _ = scene
    cells = [max(2, round(n * 2 / per_cell)) for n in sizes[D]]
    return block(cells, per_cell, shape, material)


def compile_kernels(case):
    """Compile what a case needs, in a process of its own."""
    create(case).advance()


def compile_all(cases):
    """Compile the kernels of cases, several at a time."""
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        list(pool.map(compile_kernels, cases))


def main(folder, quick):
    """Measure all scenes by turns, and write kernels.md, kernels.csv and kernels.png."""
    todo = scenes(quick)
    sizes, rounds, steps = (SMALL, 2, 4) if quick else (SIZES, 5, RESORT)
    if not quick:
        # Each kind once; positions and numbers of particles make no difference.
        compile_all({scene[:3]: case_of(scene, SMALL) for scene in todo}.values())
    timed = [Timed(create(case_of(scene, sizes), random=scene[-1]), steps) for scene in todo]
    for _ in range(rounds):
        for one in timed:
            one.round()
    rows = []
    for (D, shape, material, per_cell, random), one in zip(todo, timed, strict=True):
        rows.append({
            "dimension": D, "shape": shape, "material": material, "particles per cell": per_cell**D,
            "positions": "random" if random else "lattice",
            **one.result(**{name: one.phase_speed(name) for name in PHASES}),
        })  # fmt: skip
    columns = {
        "scene": lambda row: f"{row['dimension']}D, {row['shape']}, {row['material']}",
        "a cell": lambda row: str(row["particles per cell"]),
        "positions": lambda row: row["positions"],
        "particles": lambda row: count(row["particles"]),
        "whole step": lambda row: spread(row["speeds"]),
        "P2G": lambda row: number(row["P2G"]),
        "grid": lambda row: number(row["grid"], 0),
        "G2P": lambda row: number(row["G2P"]),
        "order": lambda row: number(row["order"], 0),
    } | ERRORS
    note = (
        "Million particle-steps/s of blocks in free fall on one core: whole steps, median (least "
        f"to greatest) of {rounds} rounds of {steps} steps, all scenes by turns; and each phase "
        "alone, `order` with the sort every 48 steps. Errors against the exact free fall, over "
        f"speed and Young's modulus. {origin()}"
    )
    write(folder, "kernels", "Whole steps", columns, rows, note)
    draw(folder, rows)
    return rows


def draw(folder, rows):
    """Bars of the time of a particle-step, split by phase."""
    rows = rows[::-1]
    names = [
        f"{r['dimension']}D {r['shape']}, {r['material']}, {r['particles per cell']} a cell, "
        f"{r['positions']}" for r in rows
    ]  # fmt: skip
    figure, axis = plt.subplots(figsize=(8.0, 1.0 + 0.19 * len(rows)))
    left = [0.0] * len(rows)
    colours = ("#1f5fa8", "#2e8b57", "#d98e04", "#c0392b", "#b0b0b0", "#404040")
    for name, colour in zip((*PHASES, "the rest"), colours, strict=True):
        if name == "the rest":
            widths = [1e3 / r["speed"] - used for r, used in zip(rows, left, strict=True)]
        else:
            widths = [1e3 / r[name] if r[name] else 0.0 for r in rows]
        widths = [max(0.0, width) for width in widths]
        axis.barh(names, widths, left=left, color=colour, label=name, height=0.75)
        left = [a + b for a, b in zip(left, widths, strict=True)]
    axis.tick_params(axis="y", labelsize=6.5)
    axis.set_xlabel("nanoseconds a particle-step, on one core")
    axis.legend(fontsize=7)
    save(figure, folder / "kernels.png")
