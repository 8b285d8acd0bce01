"""Vertices: conditions of faces and constraints, mirrors, seams, damping, absorbing faces."""
