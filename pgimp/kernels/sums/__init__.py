"""Sums over particles in an order that ranks do not change: totals, errors of exact solutions."""
