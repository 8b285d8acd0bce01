"""Studies: a case run many times with changes, and its error against its cost."""
