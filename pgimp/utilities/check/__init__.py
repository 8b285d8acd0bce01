"""Estimates of ``pgimp check`` that need a simulation: steps, time and memory."""
