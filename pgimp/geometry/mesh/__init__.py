"""Closed surfaces from mesh files: reading, checking, distance, cuts."""
