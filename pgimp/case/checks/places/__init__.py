"""Checks of what is followed in time: probes and gauges."""
