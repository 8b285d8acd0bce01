"""The part of JSON schema that the case file's schema uses, checked the slow and plain way."""

import re

NOTES = {"$schema", "$defs", "$comment", "title", "description", "default"}


class Checker:
    """Tells whether plain data satisfies a schema; refuses keywords that it does not know."""

    def __init__(self, schema):
        self.root = schema

    def __call__(self, value, schema=None):
        schema = self.root if schema is None else schema
        unknown = set(schema) - NOTES - set(RULES)
        assert not unknown, f"keywords {unknown}"
        return all(RULES[word](self, value, schema) for word in schema if word in RULES)


def is_number(value):
    return isinstance(value, int | float) and not isinstance(value, bool)


TYPES = {
    "object": lambda v: isinstance(v, dict),
    "array": lambda v: isinstance(v, list),
    "string": lambda v: isinstance(v, str),
    "boolean": lambda v: isinstance(v, bool),
    "number": is_number,
    "integer": lambda v: is_number(v) and float(v).is_integer(),
    "null": lambda v: v is None,
}


def properties(check, value, schema):
    if not isinstance(value, dict):
        return True
    known, patterns = schema.get("properties", {}), schema.get("patternProperties", {})
    extra = schema.get("additionalProperties", True)
    for key, item in value.items():
        fitting = [known[key]] if key in known else []
        fitting += [s for pattern, s in patterns.items() if re.search(pattern, key)]
        if not fitting:
            fitting = [extra] if isinstance(extra, dict) else []
            if extra is False:
                return False
        if not all(check(item, s) for s in fitting):
            return False
    return True


def items(check, value, schema):
    if not isinstance(value, list):
        return True
    first = schema.get("prefixItems", [])
    if not all(check(v, s) for v, s in zip(value, first, strict=False)):
        return False
    return "items" not in schema or all(check(v, schema["items"]) for v in value[len(first) :])


def bound(holds):
    return lambda word: lambda check, v, s: not is_number(v) or holds(v, s[word])


def length(kind, holds):
    return lambda word: lambda check, v, s: not isinstance(v, kind) or holds(len(v), s[word])


RULES = {
    "$ref": lambda check, v, s: check(v, check.root["$defs"][s["$ref"].removeprefix("#/$defs/")]),
    "type": lambda check, v, s: TYPES[s["type"]](v),
    "const": lambda check, v, s: v == s["const"],
    "enum": lambda check, v, s: v in s["enum"],
    "oneOf": lambda check, v, s: sum(check(v, one) for one in s["oneOf"]) == 1,
    "anyOf": lambda check, v, s: any(check(v, one) for one in s["anyOf"]),
    "properties": properties,
    "patternProperties": properties,
    "additionalProperties": properties,
    "propertyNames": lambda check, v, s: all(check(key, s["propertyNames"]) for key in v),
    "required": lambda check, v, s: not isinstance(v, dict) or set(s["required"]) <= set(v),
    "items": items,
    "prefixItems": items,
    "pattern": lambda check, v, s: not isinstance(v, str) or bool(re.search(s["pattern"], v)),
    "minimum": bound(lambda v, limit: v >= limit)("minimum"),
    "maximum": bound(lambda v, limit: v <= limit)("maximum"),
    "exclusiveMinimum": bound(lambda v, limit: v > limit)("exclusiveMinimum"),
    "exclusiveMaximum": bound(lambda v, limit: v < limit)("exclusiveMaximum"),
    "minLength": length(str, lambda n, limit: n >= limit)("minLength"),
    "maxLength": length(str, lambda n, limit: n <= limit)("maxLength"),
    "minItems": length(list, lambda n, limit: n >= limit)("minItems"),
    "maxItems": length(list, lambda n, limit: n <= limit)("maxItems"),
    "maxProperties": length(dict, lambda n, limit: n <= limit)("maxProperties"),
    "minProperties": length(dict, lambda n, limit: n >= limit)("minProperties"),
}
