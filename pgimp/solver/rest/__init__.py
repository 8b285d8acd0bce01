"""Rest: damping of motion, and settling before time 0."""
