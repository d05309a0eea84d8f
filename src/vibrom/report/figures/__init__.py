"""One module a figure, each with `draw(collection, scores, scene) -> Figure`; scene None: a figure
of the whole run.
"""

import matplotlib
from matplotlib.figure import Figure

from vibrom.report import names
from vibrom.report.collection import Collection
from vibrom.report.figures import (
    accuracy_cost,
    backbones,
    blow_up,
    configurations,
    cost_full_order,
    cost_reduced,
    cost_training,
    decay,
    effects,
    final_shapes,
    forced,
    frc,
    losses,
    phase_portraits,
    release_states,
    stability,
    style,
    trajectories,
)
from vibrom.report.scores import Scores

DRAW = {
    "accuracy_cost": accuracy_cost.draw,
    "configurations": configurations.draw,
    "release_states": release_states.draw,
    "trajectories": trajectories.draw,
    "losses": losses.draw,
    "phase_portraits": phase_portraits.draw,
    "decay": decay.draw,
    "backbones": backbones.draw,
    "forced": forced.draw,
    "final_shapes": final_shapes.draw,
    "blow_up": blow_up.draw,
    "frc_amplitude": frc.amplitude,
    "frc_phase": frc.phase,
    "effects": effects.draw,
    "cost_full_order": cost_full_order.draw,
    "cost_reduced": cost_reduced.draw,
    "cost_training": cost_training.draw,
    "stability_map": stability.failures,
    "stability_energy": stability.energy,
}


def draw(name: str, collection: Collection, scores: Scores) -> Figure:
    """The figure of this name, laid out once for all formats."""
    group, scene = names.split(name)
    with matplotlib.rc_context(style.STYLE):
        figure = DRAW[group](collection, scores, scene)
        figure.draw_without_rendering()
        figure.set_layout_engine("none")
        return figure
