"""Response of a material along a path, without a grid: ``pgimp element`` and `pgimp.element`."""
