"""Where a run comes from, for its report: state, starts, versions, machine, speed."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pgimp.io.rundir import runinfo
from pgimp.running.accuracy.rules import Indicator
from pgimp.running.progress import duration
from pgimp.storage.plain import read_plain
from pgimp.utilities.report.html import Markup, facts, items, table

#: Most bytes of log.txt and of a failure's report that are read, and most lines that are shown.
_MOST_BYTES, _MOST_LINES = 8 << 20, 40
#: Most particles in trouble that a report shows.
_MOST_TEXT = 6000
_TOLD = re.compile(r"(warning|note): .*")
_CHOSEN = re.compile(r"chosen: ")


def state_of(info: Mapping[str, Any], end: float | None) -> Markup:
    """Return the state of a run in words: done, failed, or how far it is."""
    state = str(info["state"])
    time = info.get("time") or 0.0
    words = {"running": "running, or killed", "starting": "starting"}.get(state, state)
    if state != "done" and end:
        words += f" at t = {time:.4g}, {100.0 * time / end:.0f} % of its time"
    kind = state if state in ("done", "failed", "stopped") else "running"
    return Markup(f'<span class="state {kind}">{words}</span>')


def speed(info: Mapping[str, Any], found: Sequence[Indicator], error: str = "") -> str:
    """Return the particle-steps in a second with the error beside; empty if unknown.

    Parameters
    ----------
    info : mapping
        The last start in run.json.
    found : sequence of Indicator
        What is known of the errors.
    error : str
        The error in words, if it is known otherwise.
    """
    steps, seconds = info.get("particle_steps"), info.get("total_seconds")
    if not steps or not seconds:
        first = info.get("resumed_from") or 0
        steps = (info.get("particles") or 0) * (info["steps"] - first)
        seconds = info.get("seconds")
    if not steps or not seconds:
        return ""
    known = {one.name: one for one in reversed(found)}
    beside = known.get("error") or known.get("lost")
    what = error or "with an error that is not known"
    if beside is not None and not error:
        what = f"{beside.rule.label}: {beside.rule.number(beside.value)}"
    return f"{steps / seconds:.3g} particle-steps/s ({what})"


def starts_table(starts: Sequence[Mapping[str, Any]]) -> Markup:
    """Return the starts of a run that was resumed, a row each."""
    if len(starts) < 2:
        return Markup()
    rows = [
        (
            one["began"],
            one["state"],
            one.get("resumed_from") if one.get("resumed_from") is not None else "the start",
            one["steps"],
            one.get("ranks", ""),
            "" if one.get("seconds") is None else duration(float(one["seconds"])),
        )
        for one in starts
    ]
    return table(("begun", "ended as", "from step", "to step", "ranks", "time of steps"), rows)


def machine(info: Mapping[str, Any]) -> Markup:
    """Return command, machine and versions."""
    hosts = info.get("hosts")
    names = ", ".join(f"{name} ({count})" for name, count in dict(hosts or {}).items())
    versions = info.get("versions")
    known = dict(versions) if isinstance(versions, dict) else {}
    system = known.pop("system", "")
    listed = ", ".join(f"{name} {number}" for name, number in known.items() if number)
    return facts(
        [
            ("command", Markup(f"<code>{_escaped(info.get('command', ''))}</code>")),
            ("in the folder", info.get("working_directory", "")),
            ("ranks, by host", names),
            ("processor", info.get("cpu", "")),
            ("system", system),
            ("versions", listed),
            ("commit", info.get("commit") or ""),
        ]
    )


def _escaped(words: object) -> str:
    return str(words).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def told(directory: Path) -> Markup:
    """Return warnings and notes of the log, each once."""
    lines = [line for line in _read(directory / "log.txt").splitlines() if _TOLD.fullmatch(line)]
    once = list(dict.fromkeys(lines))
    ordered = sorted(once, key=lambda line: not line.startswith("warning"))
    rest = len(ordered) - _MOST_LINES
    more = [f"and {rest} more in log.txt"] if rest > 0 else []
    return items([*ordered[:_MOST_LINES], *more])


def chosen(directory: Path) -> Markup:
    """Return what was chosen of the method, and why, from the log."""
    lines = [line for line in _read(directory / "log.txt").splitlines() if _CHOSEN.match(line)]
    return items([_CHOSEN.sub("", line) for line in dict.fromkeys(lines)][:_MOST_LINES])


def failure(directory: Path, info: Mapping[str, Any]) -> tuple[str, str]:
    """Return the message of a run that has failed or was stopped, and the report of particles."""
    if info["state"] not in ("failed", "stopped"):
        return "", ""
    message = str(info.get("message") or "")
    text = _read(directory / "failure" / "report.txt")
    text = text.partition("\n\nThe last lines of ")[0]  # the history has a section of its own
    text = text.partition("\n\n")[2]  # without the message
    more = "\n..." if len(text) > _MOST_TEXT else ""
    return message, text[:_MOST_TEXT] + more


def file_text(path: Path) -> str:
    """Return a file's text, cut where it is very long; empty if it cannot be read."""
    text = _read(path)
    most = 10 * _MOST_TEXT
    return text if len(text) <= most else f"{text[:most]}\n... (cut here)"


def _read(path: Path) -> str:
    try:
        return read_plain(path, _MOST_BYTES).decode(errors="replace")
    except (OSError, ValueError):
        return ""


def starts_of(directory: Path) -> list[dict[str, Any]]:
    """Return all starts of a run in run.json."""
    content = runinfo.read(directory / "run.json")
    return list(content["starts"]) if content else []
