"""The thesis's cases; what methods are called in print, in the order that gives each its colour,
dash and marker.
"""

CASES = ("small", "large", "folding")
LABELS = {
    "full_order": "Full order",
    "modal_projection": "Modal projection",
    "decoupled_autoencoder": "Decoupled AE",
    "sindy_autoencoder": "SINDy AE",
    "ssmlearn": "SSMLearn",
    "ssmlearn_11": "SSMLearn 11",
    "split": "SPLIT",
    "split_plus": "SPLIT+",
    "pysindy_modal": "pysindy modal",
    "equations": "Equations",
    "equations_orbits": "Equations (orbits)",
    "autoencoder_manifold": "AE manifold",
    "equations_corrected": "Equations (corrected)",
}
KNOWN = tuple(LABELS)[1:]  # methods with a look of their own


def label(method: str) -> str:
    """The thesis's name of a method, a variant's with what its own name adds (`SPLIT wide`); a
    method that it does not know keeps its own.
    """
    known = max(
        (name for name in LABELS if f"{method}_".startswith(f"{name}_")), key=len, default=""
    )
    return LABELS.get(known, "") + method.removeprefix(known).replace("_", " ")
