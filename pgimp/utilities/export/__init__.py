"""Frames of a run for other programs: the group and the series of VTK, tables, VTU."""
