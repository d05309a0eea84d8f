"""Whether hard cases hold: a grid of runs far from the training data, and what guards of the fitted models rescue and cost."""
