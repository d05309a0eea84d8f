"""The names of all tables and figures in reading order: the one list behind the workflow, the steps and the page."""

TABLES = (
    "beam", "eigenvalues", "reconstruction", "decay", "forced", "run_times", "frc", "cost_full_order", "cost_reduced", "cheapest", "break_even", "effects",
    "checks",
)
STABILITY_TABLES = ("stability", "guards", "full_order_steps")  # of the grid of hard cases, which not every run has
TABLE_FORMATS = ("csv", "tex", "html")
FIGURE_FORMATS = ("svg", "pdf", "png")

# One figure for the run, or one for each scene (named <group>_<scene>); the order is that of chapter 3 of the thesis.
GROUPS = {
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
    "cost_full_order": "run",
    "cost_reduced": "run",
    "cost_training": "run",
    "effects": "scene",
}
STABILITY_GROUPS = {"stability_map": "scene", "stability_energy": "scene"}

# Questions that are asked without any reduced model, and their tables and groups of figures: rules of their own make these.
FAMILIES = {"effects": {"tables": ("effects",), "figures": ("effects",)}}


def of_family(kind: str, family: str | None, names) -> list[str]:
    """Those of the `names` of this kind (`tables` or `figures`) that a family makes; None: those that none does."""
    def maker(name: str) -> str | None:
        group = name if kind == "tables" else split(name)[0]
        return next((family for family, made in FAMILIES.items() if group in made[kind]), None)

    return [name for name in names if maker(name) == family]


def figures(scenes) -> list[str]:
    """Names of the figures of a run over these scenes."""
    found = []
    for group, each in GROUPS.items():
        found += [group] if each == "run" else [f"{group}_{scene}" for scene in scenes]
    return found


def stability_figures(scenes) -> list[str]:
    """Names of the figures of the grid of hard cases over these scenes."""
    return [f"{group}_{scene}" for group in STABILITY_GROUPS for scene in scenes]


def split(figure: str) -> tuple[str, str | None]:
    """Group and scene of a figure's name; scene None for a figure of the whole run."""
    if GROUPS.get(figure) == "run":
        return figure, None
    for group, each in (GROUPS | STABILITY_GROUPS).items():
        if each == "scene" and figure.startswith(f"{group}_"):
            return group, figure.removeprefix(f"{group}_")
    raise ValueError(f"figure {figure!r}: unknown; choose from {', '.join(figures(['<scene>']))}")


def captions(scenes) -> list[str]:
    """Caption files of a run, below the folder of captions."""
    groups = dict.fromkeys(split(name)[0] for name in figures(scenes))
    return [*(f"tables/{name}.rst" for name in (*TABLES, *STABILITY_TABLES)), *(f"figures/{group}.rst" for group in (*groups, *STABILITY_GROUPS))]
