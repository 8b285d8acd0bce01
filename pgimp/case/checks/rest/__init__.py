"""Checks of what settles."""
