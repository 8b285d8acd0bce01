"""Which features of a case exclude each other: one table, for checks and pages."""
