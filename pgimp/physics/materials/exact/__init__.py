"""Exact curves of materials along paths, `Material.exact_path`."""
