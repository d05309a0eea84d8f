"""Which reduced-order model predicts a structure that bends far, how well, and what that accuracy
costs in time.
"""

__version__ = "0.2.0.dev0"
