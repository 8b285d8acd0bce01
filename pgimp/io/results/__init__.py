"""Reading results: frames, history, tables, comparison."""
