"""``pgimp completion``: the command line, read from its parsers, as scripts of shells."""
