"""Surfaces of bodies on a lattice: elements, and the parts of them that particles carry."""
