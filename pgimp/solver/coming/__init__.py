"""Particles that come in the course of a run."""
