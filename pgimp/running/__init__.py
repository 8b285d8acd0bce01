"""A run as the command makes it: output, checkpoints, log, stopping, resuming."""
