"""Keys of earlier versions, by the block in which they stood, and where the setting is now."""

from collections.abc import Collection

RENAMED = {
    ("Config", "effects"): "studies.ablation",
    ("Config", "cost"): "studies.cost",
    ("Config", "stability"): "studies.robustness",
    ("Scene", "decay"): "record",
    ("Scene", "forced"): "experiments.forced",
    ("Scene", "frc"): "experiments.frc",
}
# Whatever the block.
WORDS = {"from": "lowest", "to": "highest"}


def new_name(block: str, key: str, fields: Collection[str]) -> str | None:
    """Where an old key of a block now is; None for a key that never was."""
    word = WORDS.get(key)
    return word if word in fields else RENAMED.get((block, key))
