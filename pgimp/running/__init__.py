"""Execution of a run: output, checkpoints, log, stopping, resuming."""
