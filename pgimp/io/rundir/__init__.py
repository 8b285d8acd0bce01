"""The run directory: pgimp's files, run.json, probes' files."""
