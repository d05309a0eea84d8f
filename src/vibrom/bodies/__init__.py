"""One file a body: a frozen dataclass of the scene's `body` block whose `build()` gives the Space.

The block's `shape` is the name of the file.
"""
