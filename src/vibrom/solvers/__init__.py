"""Time integration. Solvers see operators and vector fields, never finite elements."""
