"""``pgimp plot --contours``: bodies as smooth fields within their outlines."""
