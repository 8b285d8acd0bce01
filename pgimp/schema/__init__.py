"""The language of case files: YAML with line numbers, typed entries, readable messages."""
