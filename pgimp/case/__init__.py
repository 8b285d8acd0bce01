"""The case file: typed models, reading with line numbers, writing, readable messages."""
