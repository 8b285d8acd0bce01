"""Forms of keys that may be left out, in the JSON schema of a case file."""

from __future__ import annotations

from typing import Any

from pydantic import GetJsonSchemaHandler

from pgimp.schema.registries import ByField

#: The word that says that all of the method is chosen, and the default.
AUTO_METHOD: Any = "auto"


class MethodEntry(ByField):
    """The entry of a shape, or `auto`; its name may be left out, too."""

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """See `Dispatch`."""
        forms: Any = super().document(handler)["oneOf"]
        for form in forms:
            entry = handler.resolve_ref_schema(form)
            if entry["properties"]["shape"].get("const") == "gimp":  # of which the others differ
                entry["required"] = [key for key in entry["required"] if key != "shape"]
                chosen = {key: value for key, value in entry.items() if key != "description"}
                of_shape = entry["properties"]["shape"] | {"const": AUTO_METHOD}
                chosen["properties"] = entry["properties"] | {"shape": of_shape}
                chosen["required"] = ["shape"]
        return {"oneOf": [*forms, chosen, {"const": AUTO_METHOD}]}


def or_bonded(schema: dict[str, Any]) -> None:
    """Document the words `bonded` and `auto` beside a list of entries."""
    array = {key: schema.pop(key) for key in ("items", "maxItems", "type") if key in schema}
    schema["oneOf"] = [array, {"const": "bonded"}, {"const": "auto"}]
