"""External loads: gravity and body forces at the vertices, tractions on particles."""
