"""Cost of a step on this machine: measured on small scenes like the case; and a pilot run."""
