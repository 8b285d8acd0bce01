"""Orders of phases in a step: when particles strain."""
