"""What was chosen, put into the text of a case file, whose comments and lines stay."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode

from pgimp.case.choices.choose import CHOSEN, Path
from pgimp.case.choices.kept import paths_of
from pgimp.case.writer import flow

#: Stands for `pgimp.case.schema.Case`, whose module imports the choices.
Case = Any

#: New parts of a case stand before the first of these that it has.
_BEFORE = {"method": ("time", "materials"), "contact": ("output", "history", "probes")}


def written(text: str, case: Case) -> str:
    """Return the text of a case file with what was chosen for the case of it.

    Parameters
    ----------
    text : str
        A valid case file.
    case : Case
        What was read from it, without other changes.
    """
    found: Mapping[Path, Any] = case.__dict__.get("chosen", {})
    chosen = {path: one.value for path, one in found.items()}
    root = YAML(pure=True).compose(text)
    assert isinstance(root, MappingNode)
    changes: list[tuple[int, int, str]] = []
    data = case.model_dump(by_alias=True)
    for path in (*paths_of(case.__dict__["left_out"]), ("method", "mass")) if found else ():
        node = _at(root, path)
        if isinstance(node, ScalarNode) and node.value == CHOSEN:
            value = chosen.pop(path, None) or _at_path(data, path)
            changes.append((node.start_mark.index, node.end_mark.index, flow(value)))
    values: dict[Path, dict[str, Any]] = {}
    for path, value in chosen.items():
        values.setdefault(path[:-1], {})[path[-1]] = value
    for path, given in values.items():
        _insert(text, root, path, given, changes)
    for start, end, new in sorted(changes, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def _insert(
    text: str,
    root: MappingNode,
    path: Path,
    given: dict[str, Any],
    changes: list[tuple[int, int, str]],
) -> None:
    """Add the changes of the text that give a mapping further keys."""
    at: Node | None = root
    for key in path:
        assert isinstance(at, MappingNode)
        at = _child(at, key)
    if not path:  # the entries of contact
        for key, value in given.items():
            if (old := _child(root, key)) is None:
                _new(text, root, key, value, changes)
            elif old.value != "bonded":
                changes.append((old.start_mark.index, old.end_mark.index, flow(value)))
    elif at is None:
        _new(text, root, path[-1], given, changes)
    elif not isinstance(at, MappingNode):  # auto
        changes.append((at.start_mark.index, at.end_mark.index, flow(given)))
    elif at.flow_style or not at.value:
        parts = flow(given)[1:-1]
        start = at.start_mark.index + 1
        changes.append((start, start, parts + ", " * bool(at.value)))
    else:
        first = at.value[0][0].start_mark
        indent = " " * first.column
        lines = "".join(f"{key}: {flow(value)}\n{indent}" for key, value in given.items())
        changes.append((first.index, first.index, lines))


def _new(
    text: str, root: MappingNode, key: str, value: Any, changes: list[tuple[int, int, str]]
) -> None:
    """Add a new part of the case."""
    after = next((one for one in _BEFORE[key] if _child(root, one) is not None), None)
    at = len(text)
    if after is not None:
        at = next(k.start_mark.index for k, _ in root.value if k.value == after)
    lines = f"{key}: {flow(value)}\n"
    if isinstance(value, tuple):
        lines = f"{key}:\n" + "".join(f"  - {flow(one)}\n" for one in value)
    changes.append((at, at, "\n" * (at == len(text) and not text.endswith("\n")) + lines))


def _at(node: Node | None, path: Path) -> Node | None:
    """The value at a path; None if it is not there."""
    for key in path:
        node = _child(node, key) if isinstance(node, MappingNode) else None
    return node


def _at_path(data: Any, path: Path) -> Any:
    for key in path:
        data = data[key]
    return data


def _child(node: MappingNode, key: str) -> Node | None:
    """The value of a key; None if it is not there."""
    return next((value for name, value in node.value if name.value == key), None)
