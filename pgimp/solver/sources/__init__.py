"""Particles that come and go in the course of a run."""
