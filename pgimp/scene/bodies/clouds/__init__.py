"""Bodies whose particles come from files."""
