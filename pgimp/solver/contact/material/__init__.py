"""Contact by surfaces beside material in the current configuration."""
