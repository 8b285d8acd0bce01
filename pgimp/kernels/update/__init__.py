"""Update of particles after the gather: velocity, deformation gradient, stress."""
