"""The run directory: which files are pgimp's, run.json, probes' files."""
