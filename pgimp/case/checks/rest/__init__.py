"""Checks of damping, and of what settles."""
