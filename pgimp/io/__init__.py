"""What a run leaves behind: frames, checkpoints, the run directory, and reading them again."""
