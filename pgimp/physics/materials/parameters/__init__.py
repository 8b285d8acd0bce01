"""Parameters and states of materials: where particles have them, how kernels read them."""
