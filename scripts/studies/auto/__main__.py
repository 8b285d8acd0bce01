"""Measures what no method keys give beside named methods, and writes a table; see scripts/auto."""

import os
import re
import tempfile
from pathlib import Path

from studies.auto.problem import METHODS, Problem
from studies.auto.problems import PROBLEMS
from studies.harness import CASES, Kept, options_of, origin, out, put, table

import pgimp
from pgimp.errors import PgimpError
from pgimp.schema.document import parse


def written(problem: Problem) -> dict:
    """The case of a problem as its file has it."""
    if not problem.case:
        return dict(problem.changes)
    path = CASES / f"{problem.case}.yaml"
    return parse(path.read_text(encoding="utf-8"), str(path)).data


def bare(data: dict) -> dict:
    """The case without a key of the method; contact stays where it has friction."""
    data = {key: value for key, value in data.items() if key != "method"}
    data["time"] = {key: value for key, value in data["time"].items() if key != "step"}
    if not any(set(entry) - {"bodies"} for entry in data.get("contact", ())):
        data.pop("contact", None)
    keys = ("formulation", "mass", "volumetric")
    data["bodies"] = {
        name: {key: value for key, value in body.items() if key not in keys}
        for name, body in data["bodies"].items()
    }
    return data


def named(data: dict, method: dict, contact) -> dict:
    """The bare case with a method, of former defaults elsewhere."""
    method = dict(method)
    configuration = method.pop("formulation", "updated-lagrangian")
    count = data["dimensions"]
    found = data | {"format": 1, "time": {"step": {"courant": 0.3}} | data["time"]}
    found["method"] = {"shape": "gimp", "particles-per-cell": [2] * count, **method}
    if contact:
        found["contact"] = contact
    found["bodies"] = {
        name: body if "rigid" in body else {**body, "formulation": configuration}
        for name, body in data["bodies"].items()
    }
    return found


def measured(problem: Problem, data: dict) -> tuple[float | None, float, str]:
    """Relative error, seconds of the steps, and why there is none."""
    changes = problem.changes if problem.case else {}
    # What the case's own step or frames need does not matter here.
    changes = {key: value for key, value in changes.items() if not key.startswith("time.step")}
    with tempfile.TemporaryDirectory() as folder:
        try:
            run = pgimp.run(data, output=Path(folder) / "run", overrides=changes, quiet=True)
            seconds = re.findall(r"^total +([\d.]+)", (run.path / "log.txt").read_text(), re.M)
            return float(problem.error(run)), float(seconds[-1]), ""
        except (PgimpError, ValueError, IndexError) as error:
            return None, 0.0, f"{error}".splitlines()[0][:300]


def main():
    """Measure all problems, or some."""
    some = {"among": tuple(PROBLEMS), "metavar": "PROBLEM,..", "help": "the others stay"}
    options = options_of("auto", redraw="the table from what is there", only=some)
    kept = Kept(out("auto") / "auto.json")
    os.chdir(CASES)
    for name, problem in PROBLEMS.items():
        if options.redraw or (options.only and name not in options.only):
            continue
        whole = written(problem)
        data = bare(whole)
        ways = {"auto": data}
        if problem.case:
            ways["as shipped"] = whole
        contact = whole.get("contact") or ([{"bodies": "all"}] if len(whole["bodies"]) > 1 else [])
        contact = contact if name != "Sod's tube" else []
        for way in problem.methods:
            if "mean" in way and data["dimensions"] == 1:
                continue
            ways[way] = named(data, METHODS[way], contact)
        for way, case in ways.items():
            if f"{name}: {way}" in kept and not options.only:
                continue  # of a run before this one
            found = measured(problem, case)
            kept["origin"] = origin()
            kept.add(f"{name}: {way}", found)
            print(f"{name}: {way}: {found[0]}, {found[1]:.2f} s {found[2]}", flush=True)
    put({"auto": text(kept)})


def text(kept: dict) -> str:
    """The table: errors and costs of no method keys, of the former default, and of the best."""

    def shown(found) -> str:
        error, seconds, _ = found
        return "stopped" if error is None else f"{_percent(error)}, {seconds:.1f}"

    rows = []
    for name, problem in PROBLEMS.items():
        ways = {way: kept.get(f"{name}: {way}") for way in ("as shipped", *METHODS)}
        sound = {way: found for way, found in ways.items() if found and found[0] is not None}
        auto = kept.get(f"{name}: auto")
        if auto is None or not sound:
            continue
        best = min(sound, key=lambda way: sound[way][0])
        before = ways["former default"]
        rows.append((
            name, problem.what, shown(auto), shown(before) if before else "",
            f"{best}: {shown(sound[best])}",
        ))  # fmt: skip
    titles = (
        "problem", "error of", "no method key: error in %, s", "former default", "best of the named"
    )  # fmt: skip
    return table(titles, rows, f"Measured by `scripts/auto` on {kept['origin']}.")


def _percent(part: float) -> str:
    value = 100.0 * part
    return "> 100" if value > 100.0 else "< 0.001" if value < 1e-3 else f"{value:.2g}"


if __name__ == "__main__":
    main()
