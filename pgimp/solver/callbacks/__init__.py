"""Functions of a program after every N steps."""
