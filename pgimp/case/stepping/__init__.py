"""Steps in time: the key of the case, and the largest stable ones."""
