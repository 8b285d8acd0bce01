"""``pgimp plot -o FILE.gif``: pictures of frames one after the other."""
