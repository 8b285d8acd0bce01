"""Measures exact cut cells beside weights of whole boxes; see scripts/surfaces."""

from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from studies.harness import Table, options_of, origin
from studies.scenes import ball, box, case_of, core
from studies.surfaces import at_surfaces
from studies.surfaces.bores import PROBLEMS, errors

from pgimp.kernels.data.motion import KEPT_MASS, KEPT_VELOCITY
from pgimp.kernels.data.record import RECORD

SOLID = {"model": "hooke", "young": 1.0, "poisson": 0.3, "density": 1.0}
BOTH = ("boxes", "cut")
#: Low corners of blocks, or what is added to centres, in cells.
OFFSETS = ((0.37, 0.21), (0.2, 0.6), (0.97, 0.02))
PUSH = 1e-3
WHAT = ("stress", "modes", "bores", "energy", "surfaces", "locking")


def made(size, region, surface, end, **parts):
    """A simulation of one body in the initial configuration."""
    body = {
        "material": "m",
        "region": region,
        "formulation": "total-lagrangian",
        "surface": surface,
    }
    solid = {"m": parts.pop("material", SOLID)}
    return core(case_of(size, 1.0, solid, {"b": body | parts.pop("body", {})}, end, **parts))


def finished(sim):
    while not sim.finished:
        sim.advance()
    return sim


def stresses(size, region, surface, loads, component):
    """Least and greatest stress over the exact one, at rest."""
    sim = made(size, region, surface, 150.0, tractions=loads, damping={"mass": 0.3})
    found = finished(sim).particles.sigma[sim.live()][:, component] / PUSH
    return f"{found.min():.3f} to {found.max():.3f}"


def block(offset, surface):
    """A block of four cells, pulled by two regions."""
    low = 2.0 + np.array(offset)
    loads = {
        name: {"body": "b", "region": box([0.0, y], [9.0, y + 4.0]), "traction": [0.0, t * PUSH],
               "normal": {"of": [0.0, t]}}
        for name, y, t in (("top", 4.5, 1.0), ("bottom", 0.5, -1.0))
    }  # fmt: skip
    return stresses([9.0] * 2, box(low, low + 4.0), surface, loads, [1])


def pressed(cells, surface):
    """A ball of a radius in cells, under pressure all round."""
    size = [2.0 * cells + 4.0] * 3
    middle = cells + 2.0 + np.array([0.13, -0.09, 0.27])
    load = {"body": "b", "region": box([0.0] * 3, size), "pressure": -PUSH}
    return stresses(size, ball(middle, cells), surface, {"all": load}, [0, 1, 2])


def turned(surface):
    """A cube of an STL file, turned about all axes, under pressure all round."""
    angles, R = np.radians((20.0, 15.0, 35.0)), np.eye(3)
    for axis, angle in enumerate(angles):
        i, j, one = (axis + 1) % 3, (axis + 2) % 3, np.eye(3)
        one[i, i] = one[j, j] = np.cos(angle)
        one[j, i], one[i, j] = np.sin(angle), -np.sin(angle)
        R = one @ R
    x = 3.7 * (np.array(list(product((0, 1), repeat=3))) - 0.5) @ R.T + (3.87, 4.13, 3.91)
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    lines = ["solid cube"]
    for a, b, c, d in sides:
        for corners in ((a, b, c), (a, c, d)):
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += ["vertex {:.17g} {:.17g} {:.17g}".format(*x[k]) for k in corners]
            lines += ["endloop", "endfacet"]
    load = {"all": {"body": "b", "region": box([0.0] * 3, [8.0] * 3), "pressure": -PUSH}}
    with TemporaryDirectory() as folder:
        path = Path(folder) / "cube.stl"
        path.write_text("\n".join([*lines, "endsolid cube"]))
        return stresses([8.0] * 3, {"mesh": {"file": str(path)}}, surface, load, [0, 1, 2])


def shape(kind, cells, offset):
    """Size of the domain and region of a body of so many cells."""
    low = 3.0 + np.array(offset)
    if kind == "disk":
        return [cells + 7.0] * 2, ball(low + 0.5 * cells, 0.5 * cells)
    sides = np.array([cells, cells if kind == "square" else 0.25 * cells])
    return (sides + 7.0).tolist(), box(low, low + sides)


def frequencies(kind, cells, offset, surface):
    """Frequencies of a free body times its size, by forces of the code's own steps."""
    size, region = shape(kind, cells, offset)
    sim = made(size, region, surface, 1e9, time={"step": 1e-4})
    rank, p = sim.rank, sim.particles
    kept = rank.grid.kept.values.reshape(-1, RECORD)
    still, columns = kept.copy(), ("x", "v", "F", "sigma", "V")
    before = {name: getattr(p, name).copy() for name in columns}
    there = np.flatnonzero(kept[:, KEPT_MASS] > 0.0)
    mass, forces, unit = kept[there, KEPT_MASS], [], 1e-6
    for row, d in product(range(len(there)), range(2)):
        kept[:] = still
        for name, values in before.items():
            getattr(p, name)[:] = values
        kept[there[row], KEPT_VELOCITY + d] = unit
        if rank.slaves:
            rank.slaves.spread(rank, rank.grid.kept.values, KEPT_VELOCITY)
        sim.advance()
        sim.advance()
        v = kept[there, KEPT_VELOCITY : KEPT_VELOCITY + 2].copy()
        v[row, d] -= unit
        forces.append(v.reshape(-1) / (-unit * sim.dt**2))
    root = np.sqrt(np.repeat(mass, 2))
    A = np.array(forces).T * root[:, None] / root
    found = np.sqrt(np.maximum(np.linalg.eigvalsh(0.5 * (A + A.T)), 0.0))
    speed = np.sqrt(0.7 / (1.3 * 0.4))
    return found[3:15] * cells, found[-1] / (2.0 * speed)


def energy(surface, steps):
    """Change of energy and spin of a block that turns and bends."""
    solid = SOLID | {"model": "neo-hookean", "young": 1000.0}
    spin = {"rotation": {"rate": 1.0, "about": [4.0, 4.0]}, "translation": [0.1, 0.0]}
    sim = made([10.0] * 2, box([1.97, 2.02], [7.97, 6.02]), surface, 1e9, material=solid,
               body={"velocity": spin})  # fmt: skip
    lines = [sim.diagnostics()]
    while sim.step < steps:
        for _ in range(500):
            sim.advance()
        lines.append(sim.diagnostics())
    total = np.array([line["kinetic-energy"] + line["strain-energy"] for line in lines])
    turn = np.array([line["angular-momentum-z"] for line in lines])
    last = total[-len(total) // 5 :].mean()
    return np.abs(total / total[0] - 1.0).max(), last / total[0] - 1.0, np.ptp(turn) / turn[0]


def main():
    """Measure and print."""
    what = options_of("surfaces", what={"nargs": "*"}).what or WHAT
    print(f"Measured on one core of {origin()}.\n")
    if "stress" in what:
        table = Table("stress over the exact one", *(f"`{each}`" for each in BOTH))
        for offset in OFFSETS:
            words = f"block of 4 x 4 cells from {offset} of a cell, traction by `region`"
            table.add(words, *(block(offset, each) for each in BOTH))
        for cells in (4, 8):
            table.add(f"ball, radius {cells} cells, pressure", *(pressed(cells, b) for b in BOTH))
        words = "cube of an STL file, 3.7 cells, turned about all axes, pressure"
        table.add(words, *map(turned, BOTH))
        print(table.text())
    if "modes" in what:
        table = Table("first 12 frequencies, rms of their errors; greatest over 2c/h",
                      *(f"`{each}`" for each in BOTH))  # fmt: skip
        for kind in ("square", "disk", "strip"):
            # Of cut cells, with an error of second order.
            fine = [frequencies(kind, n, OFFSETS[0], "cut")[0] for n in (20, 40)]
            truth = fine[1] + (fine[1] - fine[0]) / 3.0
            for cells in (8, 16):
                texts = []
                for surface in BOTH:
                    found, most = frequencies(kind, cells, OFFSETS[0], surface)
                    error = np.sqrt(((found / truth - 1.0) ** 2).mean())
                    texts.append(f"{100 * error:.2f} %, {most:.2f}")
                table.add(f"{kind} of {cells} cells", *texts)
        print(table.text())
    if "bores" in what:
        table = Table("errors at the bore: displacement; hoop stress, rms and greatest",
                      *(f"`{each}`" for each in BOTH))  # fmt: skip
        for problem in PROBLEMS:
            for cells in (4, 8):
                found = (errors(problem, cells, surface) for surface in BOTH)
                texts = ("; ".join(f"{each:.2g}" for each in every) + " %" for every in found)
                table.add(f"{problem[0]}, radius {cells} cells", *texts)
        print(table.text())
    if "energy" in what:
        table = Table("1e5 steps of a turning block", "greatest change of energy",
                      "of the last fifth's mean", "of spin")  # fmt: skip
        for surface in BOTH:
            table.add(f"`{surface}`", *(f"{each:.1e}" for each in energy(surface, 100_000)))
        print(table.text())
    if "surfaces" in what:
        titles = ("", "boxes, stress", "recovered", "cut cells, stress", "recovered")
        table = Table("hoop stress: greatest at the surface; rms at particles there", *titles[1:])
        for words, measure, radii in (
            ("hole, 3 is right", at_surfaces.hole, (4, 8, 16)),
            ("bore, 1.667 is right", at_surfaces.bore, (4, 8)),
        ):
            for radius in radii:
                texts = []
                for surface in BOTH:
                    found = [measure(radius, each, surface) for each in at_surfaces.OFFSETS]
                    own, there, wrong, off = np.max(found, axis=0)
                    texts += [f"{own:.2f}; {wrong:.3f}", f"{there:.2f}; {off:.3f}"]
                table.add(f"{words}: radius {radius} cells", *texts)
        print(table.text())
        table = Table("stress at the top of a bent beam over the exact one", *titles[1:])
        for height in (4, 8):
            texts = []
            for surface in BOTH:
                found = [at_surfaces.beam(height, s, surface) for s in at_surfaces.SHIFTS]
                texts += [
                    f"{min(each):.3f} to {max(each):.3f}" for each in zip(*found, strict=True)
                ]
            table.add(f"{height} cells", *texts)
        print(table.text())
    if "locking" in what:
        table = Table("cantilever, Poisson's ratio 0.4999, mean dilatation", *BOTH)
        for cells in (4, 8):
            texts = []
            for surface in BOTH:
                found = [at_surfaces.locked(cells, s, surface) for s in at_surfaces.SHIFTS]
                texts.append(f"{100 * min(found):+.1f} to {100 * max(found):+.1f} %")
            table.add(f"{cells} cells", *texts)
        print(table.text())


if __name__ == "__main__":
    main()
