"""One file a body: it makes the mesh and the finite-element space of a scene."""
