"""Whether what a run will show is what it is taken for: tearing, inertia, angles, edges."""
