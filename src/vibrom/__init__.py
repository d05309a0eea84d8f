"""Which reduced-order model predicts a structure that bends far, how well, and what that accuracy
costs in time.
"""

from importlib.metadata import PackageNotFoundError, version

try:
    __version__ = version("vibrom")
except PackageNotFoundError:  # a folder of source that nobody installed
    __version__ = "not installed"
