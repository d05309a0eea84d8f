"""Solvers of the full order: time integration, equilibria, modes."""
