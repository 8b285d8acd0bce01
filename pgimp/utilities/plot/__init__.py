"""Figures of runs: curves of the history, pictures of frames, fields along a line."""
