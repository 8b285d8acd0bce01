"""Liquids in random tanks over tens of thousands of steps: their volume, and their energy."""

import json
import random

import numpy as np
from proofs.jobs import options_of
from studies.scenes import box, case_of

import pgimp

#: What may be lost of the volume, on the mean over the last quarter; by how much the particles' own
#: volumes may be off: they are compressed by up to one per cent, and spray is void.
LOST, CARRIED = 0.02, 0.02
#: The kinetic energy at the end over the greatest, the start's included: particles that walls hold
#: keep of it what they have, though they do not move (docs/soils-and-fluids.md).
MOVES = 0.5


def main(words):
    """Run scenes; print what is lost, and the case file of those that lose too much."""
    first = {"type": int, "default": 0, "help": "number of the first scene"}
    length = {"type": float, "default": 60.0, "help": "in sqrt(depth/g)"}
    options = options_of("liquids", words, 24, first=first, length=length)
    wrong = 0
    for number in range(options.first, options.first + options.runs):
        case, depth, words = tank(random.Random(f"{options.seed} {number}"))
        faults, said = watch(case, options.length * depth**0.5)
        print(f"{number}: {words}: {said}", flush=True)
        for fault in faults:
            print(f"  wrong: {fault}\n  {json.dumps(case)}", flush=True)
        wrong += bool(faults)
    print(f"{options.runs} done, wrong: {wrong}")
    return 1 if wrong else 0


def tank(rng):
    """A tank with a liquid that starts with a velocity: its case, its depth, both in words."""
    D = rng.choice((2, 2, 2, 3))
    up = D - 1
    depth = float(rng.randint(4, 9) if D == 2 else rng.randint(3, 5))
    size = [float(rng.randint(6, 14) if D == 2 else rng.randint(3, 6)) for _ in range(up)]
    method = {
        "shape": rng.choice(("gimp", "gimp", "finite-gimp", "cpdi", "bspline-quadratic")),
        "particles-per-cell": [rng.choice((2, 2, 3)) if D == 2 else 2] * D,
        "affine": rng.random() < 0.5,
        "volumetric": rng.choice(("pointwise", "mean")),
        "pic-damping": rng.choice((0.0, 0.0, 0.1)) / depth**0.5,
    }
    law = {"model": rng.choice(("newtonian", "newtonian", "bingham")), "density": 1.0}
    law |= {"bulk": 100.0 * depth, "shear-viscosity": rng.choice((0.0, 0.01, 0.1)) * depth}
    if law["model"] == "bingham":
        law |= {"yield-stress": 0.002 * depth, "shear": 2.0 * depth, "shear-viscosity": 0.1 * depth}
    elif not law["shear-viscosity"]:
        del law["shear-viscosity"]
    pushed = [rng.uniform(-0.3, 0.3) * depth**0.5 for _ in range(up)]
    region = box([0.0] * D, [*size, depth])
    bodies = {"liquid": {"material": "liquid", "region": region, "velocity": [*pushed, 0.0]}}
    case = case_of(
        [*size, 3.0 * depth], 1.0, {"liquid": law}, bodies, 1.0e6, method=method,
        gravity=[0.0] * up + [-1.0],
        boundaries={f"{axis}-{end}": "slip" for axis in "xyz"[:D] for end in ("min", "max")},
    )  # fmt: skip
    within = rng.choice((None, None, "stone", "float"))
    if within:
        side = min(3.0, 0.5 * size[0])
        low = [0.5 * (wide - side) for wide in size]
        low.append(0.0 if within == "stone" else depth - 0.5 * side)
        block = box(low, [x + side for x in low])
        rigid = {"velocity": None} if within == "stone" else {"density": rng.uniform(0.3, 0.7)}
        case["bodies"][within] = {"rigid": rigid, "region": block}
        bodies["liquid"]["region"] = {"difference": [region, block]}
        case["contact"] = [{"bodies": ["liquid", within], "friction": rng.choice((0.0, 0.3))}]
    words = f"{D}D, {depth:g} deep, {method['shape']}, {law['model']}"
    for name in ("affine", "volumetric"):
        words += f", {name}" * (method[name] in (True, "mean"))
    return case, depth, words + (f", {within}" if within else "")


def watch(case, end):
    """What is wrong with the volumes and energies of a run, and its figures in words."""
    sim = pgimp.Simulation(case)
    lines, start = [], sim.diagnostics()["kinetic-energy"]
    for time in np.linspace(0.0, end, 121)[1:]:
        try:
            sim.advance(time)
        except pgimp.errors.RunError as error:
            return [str(error)], f"stopped at time {sim.time:.6g}"
        lines.append(sim.diagnostics())
    room, carried, energy = (
        np.array([line[name] for line in lines])
        for name in ("volume.liquid", "volume.liquid.particles", "kinetic-energy")
    )
    lost = 1.0 - float((room / carried)[-30:].mean())
    off = float(carried[-30:].mean() / lines[0]["mass"] - 1.0)
    moves = float(energy[-30:].mean() / max(energy.max(), start))
    faults = []
    if lost > LOST:
        faults.append(f"{lost:.2%} of its volume has no room")
    if abs(off) > CARRIED:
        faults.append(f"its particles have {off:+.2%} of volume more")
    if moves > MOVES:
        faults.append(f"its kinetic energy stays {moves:.2f} of the greatest")
    said = f"lost {lost:.2%}, carried {off:+.2%}, moves {moves:.3f}, {sim.steps} steps"
    return faults, said
