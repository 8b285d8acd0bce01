"""What features cost: the plain block with each of them alone, and with all."""

from statistics import median

from blocks import COURANT, GRAVITY, MATERIALS, PAD, SPEED, Timed, block, create
from kernels import compile_all
from picture import plt, save
from report import ERRORS, count, number, origin, spread, write

from pgimp.solver.simulation import RESORT

#: The block touches y-min, so that there may be a wall.
PADS = [(PAD, PAD), (0, PAD), (PAD, PAD)]


def body(low, high, material="solid"):
    """A part of the block, between two places."""
    velocity = [SPEED] + [0.0] * (len(low) - 1)
    return {
        "material": material, "region": {"box": {"min": low, "max": high}}, "velocity": velocity,
    }  # fmt: skip


def features(cells, shape="gimp"):
    """Cases by name, the plain one first; in all the block falls freely, with walls only in 3D."""
    D, h = len(cells), 1.0 / cells[-1]
    pads = PADS[:D]
    plain = block(cells, shape=shape, pad=pads)
    low = [h * below for below, _ in pads]
    high = [h * (n + below) for n, (below, _) in zip(cells, pads, strict=True)]
    middle = [h * (cells[0] // 2 + PAD), *high[1:]], [h * (cells[0] // 2 + PAD), *low[1:]]
    zero = [0.0] * D
    viscous = MATERIALS["neo-hookean"] | {"viscosity": {"linear": 0.2, "quadratic": 2.0}}
    held = {
        "body": "block",
        "region": {"box": {"min": low, "max": [low[0] + 2 * h, *high[1:]]}},
        "velocity": [SPEED] + [None] * (D - 1),
    }
    gravity = [*zero[:-1], GRAVITY]
    parts = {
        "plain": {},
        "Courant control": {"time": plain["time"] | {"step": {"courant": COURANT}}},
        "gravity as a table": {"gravity": {"table": [[0.0, gravity], [1.0, gravity]]}},
        "volume: initial": {"method": plain["method"] | {"volume": "initial"}},
        "affine": {"method": plain["method"] | {"affine": True}},
        "pic-damping": {"method": plain["method"] | {"pic-damping": 1.0}},
        "viscosity": {"materials": {"solid": viscous}},
        "traction on a face": {
            "tractions": {"pull": {"body": "block", "face": "x-max", "traction": zero}}
        },
        "pressure on a face": {
            "tractions": {"push": {"body": "block", "face": "x-max", "pressure": 0.0}}
        },
        "constraint": {"constraints": {"grip": held}},
        "wall: slip": {"boundaries": {"y-min": "slip"}},
        "wall: unilateral": {"boundaries": {"y-min": "unilateral"}},
        "wall: moving": {
            "boundaries": {"y-min": {"velocity": [0.0 if d == 1 else None for d in range(D)]}}
        },
        "two bodies": {"bodies": {"block": body(low, middle[0]), "other": body(middle[1], high)}},
        "two materials": {
            "bodies": {"block": body(low, middle[0]), "other": body(middle[1], high, "second")},
            "materials": {"solid": MATERIALS["neo-hookean"], "second": MATERIALS["hooke"]},
        },
        "outflow": {"outflow": {"x-max": "remove"}},
        "history every step": {},
    }
    if shape != "gimp":  # whose walls may be mirrors
        faces = {"boundaries": {"y-min": "slip"}}
        parts = {
            "plain": {},
            "wall: ghost": {"method": plain["method"] | {"wall": "ghost"}} | faces,
            "wall: mirror": {"method": plain["method"] | {"wall": "mirror"}} | faces,
        }
    else:
        method = plain["method"] | {"affine": True, "pic-damping": 1.0}
        names = ("Courant control", "traction on a face", "constraint", "wall: slip", "outflow")
        every = {key: value for name in names for key, value in parts[name].items()}
        every |= parts["two materials"] | {"method": method}
        every["materials"] = every["materials"] | {"solid": viscous}
        parts["most of these at once"] = every
    return {f"{shape}, {name}": plain | more for name, more in parts.items()}


def main(folder, quick):
    """Measure all by turns, and write features.md, features.csv and features.png."""
    cells, rounds, steps = ((8, 8), 2, 4) if quick else ((20, 20, 20), 6, RESORT)
    cases = features(cells)
    if quick:
        kept = ("plain", "Courant control", "history every step")
        cases = {name: case for name, case in cases.items() if name.partition(", ")[2] in kept}
    else:
        cases |= features(cells, "fuzzy-constant")
        small = features((4, 4, 4)) | features((4, 4, 4), "fuzzy-constant")
        compile_all(small.values())
    timed = {}
    for name, case in cases.items():
        sim = create(case, random=True)
        timed[name] = Timed(sim, steps, sim.diagnostics if "history" in name else None)
    for _ in range(rounds):
        for one in timed.values():
            one.round()
    rows = []
    for name, one in timed.items():
        shape = name.partition(", ")[0]
        plain = timed[f"{shape}, plain"]
        shares = [a / b for a, b in zip(one.speeds, plain.speeds, strict=True)]
        rows.append({"scene": name, **one.result(share=median(shares), shares=shares)})
    columns = {
        "scene": lambda row: row["scene"],
        "particles": lambda row: count(row["particles"]),
        "million particle-steps/s": lambda row: spread(row["speeds"]),
        "over the plain one": lambda row: number(row["share"], 2),
    } | ERRORS
    note = (
        f"A {len(cells)}D block in free fall at random positions on one core, plain and with one "
        "feature each that does not disturb its motion (a traction of nothing, a wall along which "
        f"it slides); medians (least to greatest) of {rounds} rounds of {steps} steps by turns. "
        f"{origin()}"
    )
    write(folder, "features", "What features cost", columns, rows, note)
    if not quick:
        draw(folder, rows)
    return rows


def draw(folder, rows):
    """Bars of the speeds over the plain one's."""
    rows = rows[::-1]
    figure, axis = plt.subplots(figsize=(6.5, 1.0 + 0.2 * len(rows)))
    axis.barh([row["scene"] for row in rows], [row["share"] for row in rows], color="#1f5fa8")
    axis.axvline(1.0, color="#404040", lw=0.8)
    axis.tick_params(axis="y", labelsize=7)
    axis.set_xlabel("speed over that of the plain block")
    save(figure, folder / "features.png")
