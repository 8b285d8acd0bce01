"""What ``pgimp doctor`` looks at, a module for each topic: what is found, and what to do about it.

Libraries are tried in processes of their own: one that crashes is then a finding, and the doctor
itself never initialises MPI.
"""
