"""What the larger studies are made of, and the arithmetic of costs."""
