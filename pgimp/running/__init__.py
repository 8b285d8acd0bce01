"""A run of the command: output, checkpoints, log, stopping, resuming."""
