"""torch, which only training needs. Where it is missing, the error says which extra brings it."""

try:
    import torch
except ModuleNotFoundError as missing:
    raise ModuleNotFoundError(
        "training an autoencoder needs torch, which is not installed; install vibrom[train]"
    ) from missing

__all__ = ["torch"]
