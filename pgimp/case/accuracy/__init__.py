"""The error that a quantity may have, and the case on other cells, by which it is found."""
