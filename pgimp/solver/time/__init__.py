"""The size of a step: clocks, the Courant number, its limits, and the watch over energy."""
