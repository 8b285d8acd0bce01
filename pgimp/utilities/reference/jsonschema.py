"""JSON schema of the case file, with the registered types."""

from __future__ import annotations

from typing import Any

from pgimp.case.schema import Case
from pgimp.geometry.regions import REGION
from pgimp.physics.variation import KINDS, VARIATION
from pgimp.schema.registries import COMMENT, ByKey
from pgimp.schema.time_functions import OVER_TIME

Schema = dict[str, Any]

#: Schema of a material's number that varies in space.
VARIES: Schema = {"$ref": f"#/$defs/{VARIATION.what}"}

#: Schema of a number over time.
TIMED: Schema = {"$ref": f"#/$defs/{OVER_TIME.what}"}


def json_schema() -> Schema:
    """Return the JSON schema (draft 2020-12) of a case file, for editors.

    It covers each part. Conditions between the parts (one entry a direction, whole cells, known
    materials) are in `pgimp.case.checks.parts`.
    """
    definitions: Schema = {}
    schema = _collect(Case.model_json_schema(), definitions)
    definitions[REGION.what] = {"oneOf": _named(REGION, definitions)}
    definitions[OVER_TIME.what] = {"oneOf": _named(OVER_TIME, definitions)}
    definitions[VARIATION.what] = {
        "oneOf": [_collect(kind.model_json_schema(), definitions) for kind in KINDS.values()]
    }
    materials = schema["properties"]["materials"]
    for form in next(iter(materials["patternProperties"].values()))["oneOf"]:
        _let_vary(form, definitions)
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
    schema["title"] = "pgimp case file"
    schema["$defs"] = dict(sorted(definitions.items()))
    return schema


def _let_vary(form: Schema, definitions: Schema) -> None:
    """Allow numbers of a material, or of a part of it, to vary in space."""
    for name, value in form["properties"].items():
        branches = value.get("anyOf", [value])
        if name == "viscosity" or VARIES in branches:
            continue
        for branch in branches:
            if "$ref" in branch:
                _let_vary(definitions[branch["$ref"].rpartition("/")[2]], definitions)
        if any(branch.get("type") == "number" for branch in branches):
            moved = ("description", "default")
            said = {key: value[key] for key in moved if key in value}
            rest = [{k: v for k, v in branch.items() if k not in moved} for branch in branches]
            form["properties"][name] = {"anyOf": [*rest, VARIES], **said}


def study_schema() -> Schema:
    """Return the JSON schema (draft 2020-12) of a study file, for editors."""
    from pgimp.utilities.study.schema import Study

    definitions: Schema = {}
    schema = _collect(Study.model_json_schema(), definitions)
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
    schema["title"] = "pgimp study file"
    schema["$defs"] = dict(sorted(definitions.items()))
    return schema


def _named(kind: ByKey, definitions: Schema) -> list[Schema]:
    forms = []
    for name, entry in kind.registry().items():
        content = _collect(entry.model_json_schema(), definitions)
        if name not in entry.model_fields:  # else it is the whole mapping
            content = {
                "type": "object",
                "properties": {name: content},
                "required": [name],
                "additionalProperties": False,
            }
        forms.append(content)
    return forms


def _collect(schema: Schema, definitions: Schema) -> Schema:
    """Move the definitions of `schema` to `definitions`, tidied; return the rest, tidied."""
    tidy = _tidy(schema)
    definitions.update(tidy.pop("$defs", {}))
    return tidy


def _tidy(schema: Any) -> Any:
    """Drop titles that only repeat names; replace comments of dispatch by references."""
    if isinstance(schema, list):
        return [_tidy(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    result = {}
    for key, value in schema.items():
        if key in ("properties", "patternProperties", "$defs"):
            result[key] = {name: _tidy(item) for name, item in value.items()}
        elif key == "$comment" and value.startswith(COMMENT):
            result["$ref"] = "#/$defs/" + value.removeprefix(COMMENT)
        elif key in ("default", "const", "enum"):
            result[key] = value
        elif key != "title":
            result[key] = _tidy(value)
    return result
