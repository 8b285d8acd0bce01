"""Scripts for batch systems, Slurm and PBS."""
