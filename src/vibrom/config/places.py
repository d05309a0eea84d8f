"""Folders of the results, where they are not the name of a scene or method."""

FULL_ORDER = "full_order"  # beside the methods of a scene
UNSEEDED = "unseeded"  # beside seed_0, seed_1, ...: of a method that is fitted once
