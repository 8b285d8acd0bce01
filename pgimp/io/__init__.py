"""Output of a run: frames, checkpoints, the run directory, and reading them again."""
