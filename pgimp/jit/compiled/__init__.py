"""Compiled kernels on disk: what they are named after, and files that are trusted."""
