"""Files: read without trust, written so that nothing is lost, HDF5 without MPI."""
