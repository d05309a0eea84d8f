"""Integrators of reduced models."""
