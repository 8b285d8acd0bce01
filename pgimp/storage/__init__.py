"""Files: read defensively, written safely, HDF5 without MPI."""
