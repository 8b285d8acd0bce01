"""The pictures of docs/error-against-cost.md: error over CPU time, a panel for each problem."""

from drawing.common import plt, save
from matplotlib.lines import Line2D
from studies.pareto.front import front, price, usable

from pgimp.utilities.plot import style

FAMILIES = {
    "mpm": ("points: mpm", style.GREY), "gimp": ("boxes: gimp, finite-gimp", style.BLUE),
    "finite-gimp": ("boxes: gimp, finite-gimp", style.BLUE),
    "cpdi": ("cpdi, cpdi-corners", style.GREEN),
    "cpdi-corners": ("cpdi, cpdi-corners", style.GREEN),
    "fuzzy-nearest": ("tents: fuzzy-nearest, -constant", style.ORANGE),
    "fuzzy-constant": ("tents: fuzzy-nearest, -constant", style.ORANGE),
    "bspline-quadratic": ("B-splines", style.PURPLE), "bspline-cubic": ("B-splines", style.PURPLE),
}  # fmt: skip
PEER = "Taichi, MLS-MPM"


def draw(name, problems, records, columns=3):
    rows = -(-len(problems) // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(3.3 * columns, 3.0 * rows + 0.9), squeeze=False
    )
    for axis in axes.flat[len(problems) :]:
        axis.remove()
    for axis, problem in zip(axes.flat, problems, strict=False):
        _panel(axis, problem, [r for r in records if r["problem"] == problem.name])
    for axis in axes[-1]:
        axis.set_xlabel("CPU time of the steps [s]")
    for axis in axes[:, 0]:
        axis.set_ylabel("relative error")
    figure.legend(handles=_key(), loc="outside upper center", ncol=3, fontsize=8)
    save(figure, name)


def _panel(axis, problem, records):
    best = front([r for r in records if not r.get("peer")])
    far = 1.6 * max(r["seconds"] for r in records)
    axis.step(
        [*(r["seconds"] for r in best), far], [*(r["error"] for r in best), best[-1]["error"]],
        where="post", color="#d8d8d8", lw=6.0, zorder=0, solid_capstyle="butt",
    )  # fmt: skip
    ladders = {}
    for record in filter(usable, records):
        ladders.setdefault(record["method"], []).append(record)
    for label, ladder in ladders.items():
        points = [r["seconds"] for r in ladder], [r["error"] for r in ladder]
        axis.loglog(*points, zorder=3 if label.startswith(PEER) else 2, **_look(label))
    axis.axhline(problem.target, color="#909090", lw=0.8, ls=":", zorder=1)
    costs = {
        label: price([r for r in records if r["method"] == label], problem.target)
        for label in ladders
    }
    least = min((label for label, cost in costs.items() if cost), key=costs.get, default=None)
    axis.set_title(problem.title, fontsize=10)
    if least:
        axis.text(
            0.5, 0.985, f"cheapest at {100.0 * problem.target:g} %: {least}", fontsize=6.5,
            transform=axis.transAxes, ha="center", va="top",
        )  # fmt: skip
    axis.set_ylim(top=1.0)
    for ticks in (axis.xaxis, axis.yaxis):
        style.log_ticks(ticks)


def _look(label):
    if label.startswith(PEER):
        filled = style.RED if "float32" not in label else "none"
        return {"color": style.RED, "marker": "*", "mfc": filled, "ms": 9, "lw": 0.9}
    colour = FAMILIES[label.partition(",")[0]][1]
    marker = "^" if "1 a cell" in label else "s" if "initial" in label else "o"
    filled = colour if "affine" in label else "none"
    return {
        "color": colour, "marker": marker, "mfc": filled, "ms": 3.6, "lw": 0.4, "mew": 0.8,
        "ls": "--" if "auto" in label else "-",
    }  # fmt: skip


def _key():
    colours = dict(FAMILIES.values())
    handles = [Line2D([], [], color=c, lw=3.0, label=name) for name, c in colours.items()]

    def mark(marker, label, filled="none", colour="k", size=5):
        return Line2D([], [], ls="", marker=marker, mfc=filled, color=colour, ms=size, label=label)

    return [
        *handles, mark("*", "Taichi MLS-MPM (hollow: float32)", style.RED, style.RED, 9),
        mark("o", "2 particles a cell and direction"), mark("s", "initial configuration"),
        mark("^", "1 particle a cell"), mark("o", "filled: affine", "k"),
        Line2D([], [], color="k", ls="--", lw=0.8, label="step: {courant: auto}"),
        Line2D([], [], color="#d4d4d4", lw=7.0, label="front of pgimp"),
    ]  # fmt: skip
