"""Start of a run: memory, checks of the stages, compilation, errors of particles."""
