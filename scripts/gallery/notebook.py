"""A notebook for each case: it writes the case, changes values, runs it, and draws results."""

import json

from gallery.facts import Facts

_IMPORTS = """\
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import pgimp
"""
_WRITE = """\
# The case with its comments, and what it needs, are written beside this notebook, once.
if not Path("{stem}.yaml").exists():
    subprocess.run([sys.executable, "-m", "pgimp", "init", "{name}"], check=True)
{imports}"""
_RUN = """\
# These are values of the case: change them, or add others by their keys.
changes = {{
{changes}
}}
case = pgimp.load("{stem}.yaml", changes)
run = pgimp.run(case, output="{stem}.out", overwrite=True, quiet=True)
print(f"{{run.info['seconds']:.2f}} s; columns:", *run.history.dtype.names)
"""
_HISTORY = """\
history = run.history
for name in ("kinetic-energy", "strain-energy"):
    plt.plot(history["time"], history[name], label=name)
plt.xlabel("time")
plt.legend()
plt.show()
"""
_LINE = """\
# Another frame is run.frame(0); frame.keys() are its fields.
frame = run.frame(-1)
values = frame["{field}"].reshape(len(frame["id"]), -1)[:, 0]
plt.plot(frame["position"][:, 0], values, ".-")
plt.xlabel("x")
plt.ylabel("{field}")
plt.title(f"t = {{frame.time:g}}")
plt.show()
"""
_PLANE = """\
# Another frame is run.frame(0); frame.keys() are its fields.
frame = run.frame(-1)
values = frame["{field}"]
if values.ndim > 1:
    values = np.linalg.norm(values.reshape(len(values), -1), axis=1)
plt.scatter(frame["position"][:, 0], frame["position"][:, {up}], s=2, c=values)
plt.colorbar(label="{field}")
plt.axis("equal")
plt.title(f"t = {{frame.time:g}}")
plt.show()
"""
_FIRST = ("von-mises", "plastic-strain", "plastic-shear", "pressure", "stress", "velocity")
_KEYS = (("grid", "cell"), ("method", "shape"), ("method", "particles-per-cell"), ("time", "end"))


def notebook(case: Facts) -> str:
    """The notebook of a case, as JSON."""
    cells = [_cell("markdown", number, text) for number, text in enumerate([introduction(case)])]
    cells += [_cell("code", number, text) for number, text in enumerate(programs(case), 1)]
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    kept = {"kernelspec": kernel, "language_info": {"name": "python"}}
    whole = {"cells": cells, "metadata": kept, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(whole, indent=1) + "\n"


def introduction(case: Facts) -> str:
    """What the case is."""
    said = (f"**{name}** {case.parts[name]}" for name in ("Physics", "Size"))
    return "\n\n".join((f"# {case.name}", f"{case.title}.", *said))


def programs(case: Facts) -> list[str]:
    """The cells of code, in order."""
    stem = case.name.rpartition("/")[2]
    imports = "".join(f"import {name}  # its material\n" for name in case.modules)
    there = [(room, key) for room, key in _KEYS if key in case.contents.get(room, {})]
    values = (f'    "{room}.{key}": {case.contents[room][key]!r},' for room, key in there)
    fields = case.contents["output"].get("fields", ["velocity"])
    field = next((name for name in _FIRST if name in fields), fields[0])
    drawn = _LINE if case.dimensions == 1 else _PLANE
    return [
        _IMPORTS,
        _WRITE.format(stem=stem, name=case.name, imports=imports),
        _RUN.format(stem=stem, changes="\n".join(values)),
        _HISTORY,
        drawn.format(field=field, up=case.dimensions - 1),
    ]


def _cell(kind: str, number: int, text: str) -> dict:
    own = {"execution_count": None, "outputs": []} if kind == "code" else {}
    lines = text.strip().splitlines(keepends=True)
    return {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": lines, **own}
