"""What a case and a study file may hold, as a page and as JSON schemas."""
