"""The domain in slabs: halos, migration of particles, and moving the cuts."""
