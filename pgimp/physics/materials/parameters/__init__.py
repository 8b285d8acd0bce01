"""Parameters and states of materials: storage in particles, evaluation in kernels."""
