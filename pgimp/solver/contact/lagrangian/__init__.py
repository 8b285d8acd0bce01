"""Contact of bodies in the initial configuration: proximity, shares of ranks, the solve."""
