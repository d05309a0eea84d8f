"""The published numbers, and the promises that are checked against them."""
