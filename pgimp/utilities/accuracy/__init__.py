"""Errors of a run, estimated from runs of the same case on larger cells."""
