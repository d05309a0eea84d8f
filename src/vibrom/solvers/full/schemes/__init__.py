"""One file a scheme of time integration of the full order: a setting `time.scheme`.

A file has the function `scheme(alpha)`, which gives the scheme's parameters for the numerical
damping `alpha`: modes that no step resolves lose the factor (1 - alpha)/(1 + alpha) a step. A
scheme without numerical damping has the constant `DAMPED = False`.
"""
