"""What a scene is warned of, or refused for, before it runs."""
