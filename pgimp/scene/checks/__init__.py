"""Warnings and errors about a scene before it runs."""
