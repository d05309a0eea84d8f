"""The names of all tables and figures in reading order: the one list behind the workflow, the steps
and the page.
"""

from collections.abc import Iterable
from dataclasses import dataclass

TABLE_FORMATS = ("csv", "tex", "html")
FIGURE_FORMATS = ("svg", "pdf", "png")


@dataclass(frozen=True)
class Family:
    """What is made from one set of artefacts. A group of figures is one figure of the `run`, or one
    for each `scene`, named <group>_<scene>.
    """

    tables: tuple[str, ...]
    groups: dict[str, str]


FAMILIES = {
    # the order of the figures is that of chapter 3 of the thesis
    "models": Family(
        (
            "beam",
            "eigenvalues",
            "reconstruction",
            "decay",
            "forced",
            "run_times",
            "frc",
            "break_even",
            "checks",
        ),
        {
            "accuracy_cost": "run",
            "configurations": "run",
            "release_states": "run",
            "trajectories": "run",
            "losses": "scene",
            "phase_portraits": "scene",
            "decay": "scene",
            "backbones": "run",
            "forced": "scene",
            "final_shapes": "run",
            "blow_up": "run",
            "frc_amplitude": "run",
            "frc_phase": "run",
        },
    ),
    "cost": Family(
        ("cost_full_order", "cost_reduced", "cheapest"),
        {"cost_full_order": "run", "cost_reduced": "run", "cost_training": "run"},
    ),
    "effects": Family(("effects",), {"effects": "scene"}),
    "stability": Family(
        ("stability", "guards", "full_order_steps"),
        {"stability_map": "scene", "stability_energy": "scene"},
    ),
}
GROUPS = {group: each for family in FAMILIES.values() for group, each in family.groups.items()}


def tables(*families: str) -> list[str]:
    """Names of the tables of these families; of all, where none is named."""
    return [name for family in families or FAMILIES for name in FAMILIES[family].tables]


def figures(scenes: Iterable[str], *families: str) -> list[str]:
    """Names of the figures of these families over these scenes; of all families, where none is
    named.
    """
    scenes = list(scenes)
    groups = [item for family in families or FAMILIES for item in FAMILIES[family].groups.items()]
    return [
        name
        for group, each in groups
        for name in ([group] if each == "run" else [f"{group}_{scene}" for scene in scenes])
    ]


def split(figure: str) -> tuple[str, str | None]:
    """Group and scene of a figure's name; scene None for a figure of the whole run."""
    if GROUPS.get(figure) == "run":
        return figure, None
    for group, each in GROUPS.items():
        if each == "scene" and figure.startswith(f"{group}_"):
            return group, figure.removeprefix(f"{group}_")
    raise ValueError(f"figure {figure!r}: unknown; choose from {', '.join(figures(['<scene>']))}")


def captions() -> list[str]:
    """All caption files, below the folder of captions."""
    return [
        *(f"tables/{name}.rst" for name in tables()),
        *(f"figures/{group}.rst" for group in GROUPS),
    ]
