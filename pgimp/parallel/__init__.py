"""What a run on several ranks needs: the communicator, slabs, halos, migration."""
