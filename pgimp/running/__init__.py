"""A run: output, checkpoints, log, stopping, resuming."""
