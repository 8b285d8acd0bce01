"""Bodies filled with particles: lattices, clouds of points, cut cells."""
