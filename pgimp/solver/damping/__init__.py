"""Damping of motion, and absorbing faces."""
