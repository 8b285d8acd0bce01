"""Reference of the case file, the frames and the history, in Markdown, from the schema."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from pgimp.case.checks.exclusions.feature import Place
from pgimp.case.checks.exclusions.table import EXCLUSIONS
from pgimp.case.writer import flow
from pgimp.physics.columns import GRID, PLACE, POINT, SURFACE, WHEN, Vertex
from pgimp.physics.fields import ALWAYS, FAILURE, OPTIONAL, Field
from pgimp.physics.variation import KINDS, VARIATION
from pgimp.scene.checks.warned import WARNINGS
from pgimp.schema.base import LARGEST_COUNT
from pgimp.schema.time_functions import OVER_TIME
from pgimp.solver.history.columns import HISTORY
from pgimp.utilities.reference.jsonschema import TIMED, VARIES, Schema, json_schema, study_schema

_UNIT = re.compile(
    r"\s*\[((?:length|mass|time|stress|force|energy|volume|dimensions|[\d\s/^()])+)\]"
)
Rows = Iterator[tuple[str, ...]]

_HEAD = ("key", "meaning", "unit", "allowed", "default")
_COLUMN = ("column", "meaning", "unit")

_INTRODUCTION = """\
# Reference

Every key of a case file, every field of a frame and every column of the history. This page is
what `pgimp schema --markdown` prints; `pgimp schema` prints the JSON schema for editors.

Units are those of any consistent set of length, mass and time: force is mass length/time^2,
stress is mass/(length time^2), energy is mass length^2/time^2. In 2D (plane strain) everything is
per unit thickness, in 1D per unit cross-section, so that volume is length^2 or length there.
**Tension is positive** in stresses; pressure is positive in compression.

`1e6`, `1.0e6` and `1000000` are the same number; `"1.0"` and `true` are not numbers. A name is a
letter followed by letters, digits, `-` and `_`. Each key may be overridden on the command line:
`--set time.end=3.0`, `--set bodies.bar.velocity.0=1.0` (entries of lists count from 0).
"""


_VARIATIONS = """\
Every number of a material, but for its artificial viscosity, may be a mapping instead, by which it
depends on the place of a particle at the start: `young: {table: [[0.0, 5e6], [10.0, 4e7]], over:
depth, surface: 12.0}`. See [docs/variation.md](../docs/variation.md).
"""


_TIME = """\
Where a table over time may stand, `{table: [[time, value], ..]}`, one of these may, too. So may
they, or a table, for a component of a vector: `gravity: [0.0, {ramp: {to: -9.81, duration: 1.0}}]`.
See [docs/loads-in-time.md](../docs/loads-in-time.md).
"""


_EXCLUSIONS = """\
A case with both is refused, with the line of *this*. Tests try all other pairs. NAME stands for the
name of a body, a face or a number, AXIS for a direction, LAW for a model.
"""


#: Of what both features have to be, by `Exclusion.same`.
_SAME = {"": "", "owner": ", of the same one", "axis": ", in the same direction"}

_WARNINGS = """\
What is allowed, but hardly meant. `pgimp check -v` prints the id of each warning.
"""

#: Who gives a warning, by its stage.
_GIVEN = {"check": "`pgimp check`", "start": "`pgimp check`, and a run as it starts"}


class _Section(NamedTuple):
    """Keys of a registered type."""

    heading: str
    path: str
    schema: Schema


def reference() -> str:
    """Return the page as Markdown text."""
    schema, study = json_schema(), study_schema()
    sections: list[_Section] = []
    rows = list(_rows("", schema, schema["$defs"], sections))
    pages = [_INTRODUCTION, "## Case file\n", _table(_HEAD, rows)]
    for section in sections:
        pages += [f"### {section.heading}\n", section.schema["description"] + "\n"]
        if below := list(_rows(section.path, section.schema, schema["$defs"], [])):
            pages.append(_table(_HEAD, below))
    pages += ["## Functions of time\n", _TIME]
    forms = zip(OVER_TIME.registry(), schema["$defs"][OVER_TIME.what]["oneOf"], strict=True)
    for name, form in [*forms][1:]:
        content = form["properties"][name] if len(form["properties"]) == 1 else form
        pages += [f"### `{{{name}: ..}}`\n", content["description"] + "\n"]
        pages.append(_table(_HEAD, _rows("", content, schema["$defs"], [])))
    pages += ["## Parameters that vary in space\n", _VARIATIONS]
    for name, form in zip(KINDS, schema["$defs"][VARIATION.what]["oneOf"], strict=True):
        pages += [f"### `{{{name}: ..}}`\n", form["description"] + "\n"]
        pages.append(_table(_HEAD, _rows("", form, schema["$defs"], [])))
    pages += [
        "## What excludes each other\n",
        _EXCLUSIONS,
        _table(
            ("this", "not with", "why", "instead"),
            (
                (
                    each.a.words,
                    each.b.words + _SAME[each.same],
                    *each.texts(Place((), "NAME", "NAME", "AXIS", "LAW")),
                )
                for each in EXCLUSIONS
            ),
        ),
        "## Warnings\n",
        _WARNINGS,
        _table(
            ("id", "given by", "reason", "from"),
            (
                (_code(id), _GIVEN[kind.stage], kind.reason, kind.bound)
                for id, kind in WARNINGS.items()
            ),
        ),
        "## Frames\n",
        "`frames/particles-NNNNNN.h5`, one row a particle in ascending `id`. Always there:\n",
        _fields(ALWAYS),
        "As `output.fields` asks for:\n",
        _fields(OPTIONAL),
        "`frames/grid-NNNNNN.h5` has the cells that hold centres of particles (`connectivity`),\n"
        "and all vertices with mass and the corners of those cells, ordered by x, then y, then z.\n"
        "A vertex has a `position` and, as `output.grid` asks for, what the particles of the\n"
        "frame of the same number give it as the next step begins; w is a particle's weight:\n",
        _fields(GRID),
        "`frames/surface-NNNNNN.h5` has the surfaces of bodies that meet by them: points\n"
        "(`position`) and cells (`connectivity`), lines in 2D, quadrilaterals in 3D. A cell has\n"
        "its `body`, rigid ones after the others, `normal` and `area`, and, as `output.surface`\n"
        "asks for:\n",
        _table(
            ("dataset", "meaning", "unit"),
            ((_code(name), *_split(text)) for name, text in SURFACE.items()),
        ),
        "When a particle stops the run, `failure/particles.h5` holds it and those around it, as\n"
        "they were computed, with all fields but `rank` and\n",
        _fields(FAILURE),
        "## History\n",
        "The columns of `history.csv`, in their order. AXIS is `x`, `y`, `z`, as many as the case "
        "has dimensions; NAME is each body, FACE each face that the case names.\n",
        _table(
            _COLUMN,
            (
                (_code(column.name), column.meaning, column.unit)
                for group in HISTORY
                for column in group.columns
            ),
        ),
        "## Probes\n",
        "`probes/NAME.csv` of a material point. After a particle was removed (`outflow`), all but\n"
        "time and step are empty.\n",
        _columns(POINT),
        "`probes/NAME.csv` of a place X: means over the particles around it, each with the weight\n"
        "that a vertex of the grid there would have in linear interpolation, the product of\n"
        "max(0, 1 - |x - X|/L) over the directions, L the cell. Where the volume fraction\n"
        "is below 0.25 there is no material, and what follows is empty; at a flat surface it\n"
        "is 0.5.\n",
        _columns(WHEN | {name: mean.meaning for name, mean in PLACE.items()}),
        "## Study file\n",
        "What `pgimp study` takes. Key paths are those of `--set`. An entry of `sweep` is like\n"
        "`{grid.cell: [[2.0], [1.0]], time.step: [2.0e-3, 1.0e-3]}`, two runs, or like\n"
        "`{gimp: {method.shape: gimp}, mpm: {method.shape: mpm, time.step: 2.0e-4}}`, two others\n"
        "with names of their own.\n",
        _table(_HEAD, _rows("", study, study["$defs"], [])),
    ]
    return "\n".join(pages)


def _number(names: list[str]) -> str:
    """Return the number of components, and their names if more than three."""
    return f"{len(names)}: {' '.join(names)}" if len(names) > 3 else str(max(1, len(names)))


def _columns(columns: Mapping[str, str]) -> str:
    rows = [(_code(name), *_split(text)) for name, text in columns.items()]
    return _table(_COLUMN, rows)


def _fields(fields: Mapping[str, Field] | Mapping[str, Vertex]) -> str:
    rows = [
        (_code(name), _number(item.components.split()), *_split(item.meaning))
        for name, item in fields.items()
    ]
    return _table(("dataset", "components", "meaning", "unit"), rows)


def _rows(
    path: str,
    schema: Schema,
    definitions: Schema,
    sections: list[_Section],
    forms: Sequence[Schema] = (),
) -> Rows:
    """Yield a table row for every key below `path`.

    Registered types are added to `sections`. The mapping at `path` may be one of several `forms`; a
    key is required if all of them require it.
    """
    for name, value in _properties(schema).items():
        key = f"{path}.{name}" if path else name
        whole = _resolve(value, definitions)
        if name in schema.get("required", ()):
            always = all(name in form.get("required", ()) for form in forms)
            default = "required" if always else ""
        else:
            default = value.get("$comment", "zero")
            if "default" in value:
                default = _code(flow(value["default"]))
        meaning = _split(value.get("description", whole.get("description", "")))
        yield _code(key), *meaning, _allowed(whole, definitions), default
        yield from _below(key, whole, definitions, sections)
    named = [*schema.get("patternProperties", {}).values(), schema.get("additionalProperties")]
    for value in named:
        if isinstance(value, dict):
            faces = "enum" in schema.get("propertyNames", {})
            place = "FACE" if faces else "NAME"
            yield from _below(f"{path}.{place}", value, definitions, sections)


def _below(path: str, value: Schema, definitions: Schema, sections: list[_Section]) -> Rows:
    """Yield the rows below `path` for every form of its value."""
    forms = _forms(value, definitions)
    known: set[str] = set()
    for form in forms:
        word = _word(form)
        if "properties" in (item := _resolve(form.get("items", {}), definitions)):
            yield from _rows(f"{path}.ENTRY", item, definitions, sections)
        elif word is None:
            for row in _rows(path, form, definitions, sections, forms):
                if row[0] not in known:  # not in an earlier form
                    yield row
            known |= {row[0] for row in _rows(path, form, definitions, [], forms)}
        elif "description" in form:  # else a plain word, no type
            entry = f"{{{_key_of(form)}: {word}, ...}}" if "properties" in form else word
            section = _Section(f"`{path}: {entry}`", path, form)
            if section not in sections:
                sections.append(section)


def _properties(schema: Schema) -> Schema:
    """Return the properties, first the type's name."""
    found = schema.get("properties", {})
    return dict(sorted(found.items(), key=lambda item: "const" not in item[1]))


def _key_of(form: Schema) -> str | None:
    """Return the property that names the type of a mapping."""
    return next((key for key, item in form.get("properties", {}).items() if "const" in item), None)


def _word(form: Schema) -> str | None:
    """Return the name of a registered type, None for any other form."""
    key = _key_of(form)
    return form.get("const") if key is None else form["properties"][key]["const"]


def _forms(schema: Schema, definitions: Schema) -> list[Schema]:
    """Return the forms of a value, with nested choices."""
    whole = _resolve(schema, definitions)
    choices = whole.get("oneOf", whole.get("anyOf"))
    if choices is None:
        return [whole]
    return [
        form
        for choice in choices
        if choice != VARIES  # the same everywhere, so stated once
        for form in _forms(choice, definitions)[: 1 if choice == TIMED else None]  # likewise
    ]


def _resolve(schema: Schema, definitions: Schema) -> Schema:
    if "$ref" not in schema:
        return schema
    return {**definitions[schema["$ref"].rpartition("/")[2]], **schema}


def _allowed(schema: Schema, definitions: Schema) -> str:
    """Describe the allowed values."""
    forms = _forms(schema, definitions)
    return " or ".join(dict.fromkeys(_form(form, definitions) for form in forms))


def _form(form: Schema, definitions: Schema) -> str:
    if (word := _word(form)) is not None:
        return _code(word)
    if "enum" in form:
        return ", ".join(_code(str(value)) for value in form["enum"])
    kind = form["type"]
    if kind == "array":
        if "prefixItems" in form:
            return f"[{', '.join(_allowed(item, definitions) for item in form['prefixItems'])}]"
        if "properties" in _resolve(form["items"], definitions):
            return "list of entries"
        if "$ref" in form["items"]:
            return f"list of {form['items']['$ref'].rpartition('/')[2]}s"
        return "list of " + re.sub(
            "^(whole )?number", r"\1numbers", _allowed(form["items"], definitions)
        )
    if kind == "object":
        keys = [key for key in form.get("required", ()) if key in form.get("properties", {})]
        if form.get("additionalProperties") is True:
            return "keys as in the case"
        return _code("{" + ", ".join(f"{key}: .." for key in keys) + "}") if keys else "keys below"
    if kind == "string":
        return "name" if "pattern" in form else "text"
    if kind == "boolean":
        return "`true` or `false`"
    if kind == "null":
        return _code("null")
    limits = [
        f"{sign} {form[bound]:g}"
        for bound, sign in _BOUNDS.items()
        if bound in form and form[bound] != LARGEST_COUNT
    ]
    return f"{'whole ' if kind == 'integer' else ''}number {' and '.join(limits)}".rstrip()


_BOUNDS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}


def _split(text: str) -> tuple[str, str]:
    """Return meaning and unit of a description."""
    match = _UNIT.search(text)
    return (_UNIT.sub("", text, count=1), match[1]) if match else (text, "")


def _code(text: str) -> str:
    return f"`{text}`"


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [head, tuple("---" for _ in head), *rows]
    escaped = (" | ".join(cell.replace("|", "\\|") for cell in line) for line in lines)
    return "".join(f"| {line} |\n" for line in escaped)
