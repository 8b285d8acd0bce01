"""Measures what no method keys give beside named methods, and writes a table; see scripts/auto."""

import os
import signal
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from studies.auto.problem import FORMER, METHODS, Problem
from studies.auto.problems import PROBLEMS
from studies.harness import CASES, Kept, options_of, origin, out, put, table

import pgimp
from pgimp.errors import PgimpError
from pgimp.running import running
from pgimp.schema.document import parse


def written(problem: Problem) -> dict:
    """The case of a problem as its file has it."""
    if not problem.case:
        return dict(problem.changes)
    path = CASES / f"{problem.case}.yaml"
    return parse(path.read_text(encoding="utf-8"), str(path)).data


def bare(data: dict) -> dict:
    """The case without a key of the method; contact stays where it has friction or is bonded."""
    data = {key: value for key, value in data.items() if key != "method"}
    data["time"] = {key: value for key, value in data["time"].items() if key != "step"}
    if data.get("contact") and not any(set(entry) - {"bodies"} for entry in data["contact"]):
        del data["contact"]
    keys = ("formulation", "mass", "volumetric")
    data["bodies"] = {
        name: {key: value for key, value in body.items() if key not in keys}
        for name, body in data["bodies"].items()
    }
    return data


def named(data: dict, method: dict, contact) -> dict:
    """The bare case with a method, of former defaults elsewhere."""
    method = dict(method)
    configuration = method.pop("formulation")
    method["particles-per-cell"] = [method["particles-per-cell"]] * data["dimensions"]
    found = data | {"format": 1, "time": {"step": {"courant": 0.3}} | data["time"]}
    found["method"] = method
    if contact:
        found["contact"] = contact
    found["bodies"] = {
        name: body if "rigid" in body else {**body, "formulation": configuration}
        for name, body in data["bodies"].items()
    }
    return found


def measured(problem: Problem, data: dict, limit: float) -> tuple[float | None, float, str]:
    """Relative error, seconds of the processor in the steps, and why there is none."""
    changes = problem.changes if problem.case else {}
    # What the case's own step or frames need does not matter here.
    changes = {key: value for key, value in changes.items() if not key.startswith("time.step")}
    running.perf_counter = clock = Clock()
    signal.setitimer(signal.ITIMER_PROF, limit + 60.0)  # kernels compile besides
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run"
        try:
            run = pgimp.run(data, output=path, overrides=changes, quiet=True)
            return float(problem.error(run)), clock.last - clock.first, ""
        except TimeoutError:
            return None, limit, f"longer than {limit:.0f} s"
        except (PgimpError, ValueError, IndexError) as error:
            if problem.stopped and clock.last:
                return problem.stopped(str(error)), clock.last - clock.first, ""
            return None, 0.0, f"{error}".splitlines()[0][:300]
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)


class Clock:
    """Time of the processor, so that other programs matter less, as the run asks for it."""

    first: float | None = None
    last: float | None = None

    def __call__(self) -> float:
        """Return the time; the first one is that of the run's first step."""
        self.last = time.process_time()
        self.first = self.last if self.first is None else self.first
        return self.last


def _too_long(*_):
    raise TimeoutError


def main():
    """Measure all problems, or some."""
    some = {"among": tuple(PROBLEMS), "metavar": "PROBLEM,..", "help": "the others stay"}
    options = options_of(
        "auto", redraw="the table from what is there", only=some,
        again="measure anew the costs of what is compared, in turns",
    )  # fmt: skip
    kept = Kept(out("auto") / "auto.json")
    os.chdir(CASES)
    signal.signal(signal.SIGPROF, _too_long)
    for name, problem in PROBLEMS.items():
        if options.redraw or (options.only and name not in options.only):
            continue
        ways = _ways(name, problem)
        if options.again:
            _again(kept, name, problem, ways)
            continue
        for way, case in ways.items():
            if f"{name}: {way}" in kept and not (options.only and way == "auto"):
                continue  # of a run before this one
            limit = 600.0 if way == "auto" else 6.0 * kept[f"{name}: auto"][1] + 20.0
            found = measured(problem, case, limit)
            kept["origin"] = origin()
            kept.add(f"{name}: {way}", found)
            print(f"{name}: {way}: {found[0]}, {found[1]:.2f} s {found[2]}", flush=True)
    put({"auto": text(kept)})


def _ways(name: str, problem: Problem) -> dict[str, dict]:
    """The cases to compare, by their names."""
    whole = written(problem)
    data = bare(whole)
    contact = whole.get("contact", [{"bodies": "all"}] if len(whole["bodies"]) > 1 else [])
    contact = contact if name != "Sod's tube" else []
    ways = {"auto": data}
    for way in problem.methods:
        if "mean" not in way or data["dimensions"] > 1:
            ways[way] = named(data, METHODS[way], contact)
    return ways


def _again(kept: Kept, name: str, problem: Problem, ways: dict[str, dict]) -> None:
    """Measure costs anew, those of what is compared in turns; the least counts."""
    result = judged(kept, name, problem)
    for way in dict.fromkeys(("auto", result.best, result.rival)) if result else ():
        error, seconds, why = kept[f"{name}: {way}"]
        found = measured(problem, ways[way], 600.0)
        kept.add(f"{name}: {way}", (error, min(seconds, found[1]), why))
        print(f"{name}: {way}: {found[0]}, {seconds:.2f} s, {found[1]:.2f} s", flush=True)


class Result(NamedTuple):
    """What no method key gives beside the named methods of a problem."""

    error: float
    seconds: float
    best: str  #: The method of the least error.
    rival: str  #: The cheapest of those whose error is no more than 1.2 of ours.
    strict: bool  #: Within 1.2 of the error of the best, at 1.5 of its cost.
    accurate: bool  #: Within 1.2 of the least error, where errors below 1 % count as 1 %.
    cheap: bool  #: At no more than 1.5 of the cost of the rival.


def judged(kept: Kept, name: str, problem: Problem) -> Result | None:
    """Return the result of a problem; None where it is not measured."""
    ways = {way: kept.get(f"{name}: {way}") for way in problem.methods}
    sound = {way: found for way, found in ways.items() if found and found[0] is not None}
    auto = kept.get(f"{name}: auto")
    if auto is None or auto[0] is None or not sound:
        return None
    error, seconds, _ = auto
    best = min(sound, key=lambda way: tuple(sound[way][:2]))
    good = [way for way, found in sound.items() if _much(found[0]) <= 1.2 * _much(error)]
    rival = min(good, key=lambda way: sound[way][1], default=best)
    return Result(
        error, seconds, best, rival,
        error <= 1.2 * sound[best][0] and seconds <= 1.5 * sound[best][1],
        _much(error) <= 1.2 * _much(sound[best][0]),
        not good or seconds <= 1.5 * sound[rival][1],
    )  # fmt: skip


def _much(error: float) -> float:
    return max(error, 0.01)


def text(kept: dict) -> str:
    """The table: errors and costs of no method keys, of the former default, and of the best."""

    def shown(found) -> str:
        error, seconds, _ = found
        return "stopped" if error is None else f"{_percent(error)}, {seconds:.1f}"

    rows, results = [], []
    for name, problem in PROBLEMS.items():
        if (result := judged(kept, name, problem)) is None:
            continue
        results.append(result)
        ways = {way: kept.get(f"{name}: {way}") for way in ("auto", FORMER, *problem.methods)}
        sides = [f"{way}: {shown(ways[way])}" for way in (result.best, result.rival)]
        rows.append((
            name, problem.what, shown(ways["auto"]), shown(ways[FORMER]) if ways[FORMER] else "",
            sides[0], sides[1] if result.rival != result.best else "the same",
            sum(found is not None and found[0] is not None for found in ways.values()) - 1,
            " ".join(["yes" if result.accurate else "**no**", "yes" if result.cheap else "**no**"]),
        ))  # fmt: skip
    titles = (
        "problem", "error of", "no method key: error in %, s", "`gimp`", "least error",
        "cheapest as good", "methods", "accurate, cheap",
    )  # fmt: skip
    both = sum(one.accurate and one.cheap for one in results)
    note = (
        f"Of {len(results)} problems {sum(one.accurate for one in results)} are accurate, "
        f"{sum(one.cheap for one in results)} cheap, {both} both; "
        f"{sum(one.strict for one in results)} in the strict reading.\n\n"
        f"Measured by `scripts/auto` on {kept['origin']}."
    )
    return table(titles, rows, note)


def _percent(part: float) -> str:
    value = 100.0 * part
    return "> 100" if value > 100.0 else "< 0.001" if value < 1e-3 else f"{value:.2g}"


if __name__ == "__main__":
    main()
