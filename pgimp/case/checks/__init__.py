"""Checks of a case: conditions between its parts, after each part is read."""
