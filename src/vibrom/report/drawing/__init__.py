"""What figures share: their style, panels with words, deformed bodies."""
