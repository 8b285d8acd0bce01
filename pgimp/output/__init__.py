"""What a run leaves behind, how it is written on any number of ranks, and how it is read again."""
