"""Update of the particles after the gather: velocity, deformation gradient, stress, checks."""
