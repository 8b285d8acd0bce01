"""What a material does along a path, without a grid: ``pgimp element`` and `pgimp.element`."""
