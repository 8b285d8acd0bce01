"""What a particle takes from the grid in a step, an update a file, inlined into one kernel.

`pgimp.kernels.g2p` calls them for four particles at a time, in the order of the algorithm: velocity
and position, deformation, stress, checks. Another transfer is another `velocity`, chosen by the
types of what it gets, another way to integrate the stress another `stress`.
"""
