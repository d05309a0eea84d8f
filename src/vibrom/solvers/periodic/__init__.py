"""Periodic motions: return maps, their derivatives, continuation and stability."""
