"""Checkpoint files: layout, writing, reading."""
