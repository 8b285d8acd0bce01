"""MPI: the communicator, or its stand-in, and work that all ranks agree on."""
