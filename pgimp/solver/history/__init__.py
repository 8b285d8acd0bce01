"""Lines of history.csv: totals, columns, diagnostics."""
