"""MPI: the communicator, or what stands in for it, and work that all ranks agree on."""
