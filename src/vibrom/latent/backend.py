"""torch, which only training needs. Where it is missing, the error says which extra brings it."""

from vibrom.artefacts.extras import need

need("torch", "training an autoencoder", "train")
import torch  # noqa: E402

__all__ = ["torch"]
