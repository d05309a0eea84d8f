"""Methods of integration of reduced models, one file each, found by listing this folder.

A file defines `stepper(time_scale, steps) -> Stepper`: the method for a model whose fastest motion
is sin(t / time_scale), in `steps` steps to a period of it where the method takes equal ones.
"""
