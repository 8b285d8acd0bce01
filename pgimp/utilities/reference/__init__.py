"""Reference of case and study files, as a page and as JSON schemas."""
