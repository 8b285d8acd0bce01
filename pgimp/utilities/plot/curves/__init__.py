"""Curves of histories and probes, and their spectra."""
