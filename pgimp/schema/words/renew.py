"""Renewal of what a file says: its data, and on request its text, with new words for old ones."""

from __future__ import annotations

from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.nodes import MappingNode, Node, SequenceNode

from pgimp.errors import CaseError
from pgimp.schema.document import Document, Path, few, parse
from pgimp.schema.messages import dotted
from pgimp.schema.words.renamed import new_key, new_value


def renew(document: Document, filename: str) -> None:
    """Put new words in place of old ones; the document remembers what was written.

    Raises
    ------
    CaseError
        If a key is there by both names.
    """
    twice: list[str] = []
    document.data = _renewed_part(document.data, (), document, filename, twice)
    if twice:
        raise CaseError(few(twice, filename))
    if document.old_keys:
        new = {(*path[:-1], old): path[-1] for path, old in document.old_keys.items()}
        document.locations = {
            _new_path(path, new): where for path, where in document.locations.items()
        }


def _renewed_part(
    data: Any, path: Path, document: Document, filename: str, twice: list[str]
) -> Any:
    """Return the part at a path with new words; it stays itself as it is."""
    if isinstance(data, str):
        if (word := new_value(path, data)) != data:
            document.old_values[path] = data
        return word
    if isinstance(data, list | tuple):
        if not any(isinstance(item, str | dict | list | tuple) for item in data):
            return data
        parts = enumerate(data)
        return [_renewed_part(item, (*path, i), document, filename, twice) for i, item in parts]
    if not isinstance(data, dict):
        return data
    found = {}
    for old, value in data.items():
        new = new_key(path, old)
        if new != old:
            if new in data:
                twice.append(_both(document, (*path, old), str(new), filename))
            document.old_keys[*path, new] = old
        found[new] = _renewed_part(value, (*path, new), document, filename, twice)
    return found


def _both(document: Document, path: Path, new: str, filename: str) -> str:
    """Message: a key is there by its old and its new name."""
    here, there = document.locations.get(path), document.locations.get((*path[:-1], new))
    where = f"{filename}:{here}" if isinstance(here, int) else here or filename
    also = f", in line {there}" if isinstance(there, int) else f", by {there}" if there else ""
    key = dotted(document.as_written(path))
    return f"{where}: {key}: the older word for '{new}', which is there, too{also}; remove one"


def _new_path(path: Path, new: dict[Path, str | int]) -> Path:
    """Return a path by the new names of its keys."""
    found: Path = ()
    for key in path:
        found = (*found, new.get((*found, key), key))
    return found


def renewed(data: dict[str, Any]) -> dict[str, Any]:
    """Return a case as plain data with new words.

    Raises
    ------
    CaseError
        See `renew`.
    """
    document = Document(data)
    renew(document, "case")
    found: dict[str, Any] = document.data
    return found


def renewed_text(text: str) -> str:
    """Return the text of a valid case file with new words; comments and lines stay."""
    document = parse(text, "case")
    renew(document, "case")
    root: Node = YAML(pure=True).compose(text)
    changes: list[tuple[Node, str]] = []
    for path in document.old_keys:
        key, _ = _at(root, document.as_written(path))
        changes.append((key, str(path[-1])))
    for path, old in document.old_values.items():
        _, value = _at(root, document.as_written(path))
        changes.append((value, new_value(path, old)))
    for node, new in sorted(changes, key=lambda one: -one[0].start_mark.index):
        text = text[: node.start_mark.index] + new + text[node.end_mark.index :]
    return text


def _at(root: Node, path: Path) -> tuple[Node, Node]:
    """Return the nodes of the last key of a path, and of its value; of an item twice the same."""
    key = node = root
    for part in path:
        if isinstance(node, MappingNode):
            key, node = next((k, v) for k, v in node.value if k.value == part)
        elif isinstance(node, SequenceNode):
            key = node = node.value[part]
    return key, node
