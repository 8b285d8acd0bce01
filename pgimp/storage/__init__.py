"""Files: defensive reading, safe writing, HDF5 without MPI."""
