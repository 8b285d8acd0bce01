"""Updates of particles from the grid in a step, a file each, inlined into one kernel.

`pgimp.kernels.g2p` calls them for four particles at a time, in the order of the algorithm: velocity
and position, deformation, stress, checks. Another transfer is another `velocity`, chosen by
the types of its arguments, another integration of the stress another `stress`.
"""
