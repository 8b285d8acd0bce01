"""A run read again: frames, history, tables, comparison."""
