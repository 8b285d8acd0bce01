"""Checks of ``pgimp doctor``, a module for each topic: findings, and what to do about them.

Libraries are tried in processes of their own: one that crashes is then a finding, and the doctor
itself never initialises MPI.
"""
