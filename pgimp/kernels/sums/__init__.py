"""Sums over particles in an order independent of ranks: totals, errors of exact solutions."""
