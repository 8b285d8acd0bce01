"""Update of the vertices: momentum, conditions of faces and constraints, mirrors, filling."""
