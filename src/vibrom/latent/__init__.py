"""Pieces that methods share: polynomial libraries, autoencoders, the training loop."""
