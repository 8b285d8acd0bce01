"""Grips that given forces move."""
