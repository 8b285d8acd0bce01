"""Material in the current configuration before surfaces, and at vertices beside them."""
