"""Checks of ``pgimp doctor``, a module for each topic: findings and remedies.

Libraries are tried in separate processes: a crash is then a finding, and the doctor itself never
initialises MPI.
"""
