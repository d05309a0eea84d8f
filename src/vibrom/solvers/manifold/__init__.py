"""Invariant manifolds of  M q'' + C q' + K q + f(q) = p u(t),  from the equations alone."""
