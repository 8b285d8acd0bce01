"""Rest: damping of motion."""
