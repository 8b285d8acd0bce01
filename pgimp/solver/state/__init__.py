"""State that outlives a step: checkpoints, frames of the grid, probes."""
