"""Flows: filled parts of cells, positions that even them out, calmed motion."""
