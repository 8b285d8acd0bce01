"""The scene of a case: regions, tables, and the particles that fill the bodies."""
