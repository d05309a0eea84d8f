"""Work and precision of the full-order model: error over wall time for time steps, tolerances and
meshes, with observed orders.
"""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from vibrom.report import cost
from vibrom.report.collection import FULL_ORDER, described
from vibrom.report.figures import panels, style
from vibrom.studies.work_precision import observed_order

CONVERGED = 15.0  # %: larger errors are not yet those of the leading order
ASKED = {
    "decay": "decay: NMTE [%]",
    "forced": "forced run, last period: NMTE [%]",
    "frequency": "first frequency: error [%]",
    "response": "forced amplitude: error [%]",
}


def draw(collection, scores, scene=None) -> Figure:
    known = cost.studied(collection, "cost_full_order")
    figure = Figure(figsize=(7.4, 6.4 * max(1, len(known))))
    axes = figure.subplots(2 * max(1, len(known)), 2, squeeze=False)
    for panel in axes.flat:
        panel.set(xlabel="wall time of one run [s]", ylabel="error [%]", xscale="log", yscale="log")
    if not known:
        panels.words(axes[0, 0], "no scene of this run was studied")
    for index, (name, dataset) in enumerate(known.items()):
        for question, panel in zip(ASKED, axes[2 * index : 2 * index + 2].flat):
            panel.set(ylabel=ASKED[question], title=name if question == "decay" else "")
            if question in ("decay", "forced"):
                in_time(panel, dataset, question)
            else:
                structure = collection.find(name, FULL_ORDER, "structure")
                of_mesh(
                    panel,
                    dataset,
                    question,
                    {} if structure is None else described(structure, "body"),
                )
            own = float(dataset["reference_error"].sel(question=question))
            panel.axhline(own, color="0.6", linewidth=0.8, linestyle=":")
            panel.annotate(
                "error of the reference itself",
                (0.02, own),
                xycoords=("axes fraction", "data"),
                ha="left",
                va="bottom",
                fontsize=6,
                color="0.4",
            )
            panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), fontsize=6.5, ncols=1)
            panels.decades(panel.xaxis)
            panels.decades(panel.yaxis)
    return figure


def in_time(panel, dataset: xr.Dataset, question: str) -> None:
    """A line a scheme, over the time step, and one over the residual."""
    steps, study = dataset["steps_per_period"].values, dataset["study"].values
    error, seconds = (dataset[name].sel(question=question).values for name in ("error", "seconds"))
    alpha, start = dataset["alpha"].values, dataset["initial_acceleration"].values
    floor, schemes = 5 * float(dataset["reference_error"].sel(question=question)), {}
    for index in np.flatnonzero(study == "step"):
        schemes.setdefault((alpha[index], start[index]), []).append(index)
    drawn = set()
    for (damping, first), chosen in schemes.items():
        if question == "forced" and damping in drawn:
            continue  # from rest every start is the same
        drawn.add(damping)
        chosen = np.array(chosen)
        order = observed_order(1 / steps[chosen], error[chosen], floor=floor, ceiling=CONVERGED)
        words = f"α = {damping:g}" + (
            f", a(0) {'of the equation' if first == 'equilibrium' else 'zero'}"
            if question == "decay"
            else ""
        )
        stopped = [
            f"T/{steps[index]:.0f}"
            for index in chosen
            if dataset["outcome"].sel(question=question).values[index] == "no_convergence"
        ]
        ended = f"; no convergence at {', '.join(stopped)}" if stopped else ""
        panel.plot(
            seconds[chosen],
            error[chosen],
            label=f"{words}: order {order:.2f}{ended}",
            **style.look(len(drawn) + (first == "zero")),
        )
        if len(drawn) == 1 and first == "equilibrium":
            for index in chosen[np.isfinite(error[chosen])]:
                panel.annotate(
                    f"T/{steps[index]:.0f}",
                    (seconds[index], error[index]),
                    textcoords="offset points",
                    xytext=(-4, -8),
                    ha="right",
                    fontsize=6,
                )
    chosen = np.flatnonzero(study == "residual")
    if len(chosen) and np.isfinite(error[chosen]).any():
        tolerances = dataset["residual"].values[chosen][np.isfinite(error[chosen])]
        panel.plot(
            seconds[chosen],
            error[chosen],
            label=f"residual {tolerances.max():.0e} to {tolerances.min():.0e} at T/{steps[chosen[0]]:.0f}, α = 0",
            **style.look(6, linestyle="none"),
        )


def of_mesh(panel, dataset: xr.Dataset, question: str, body: dict) -> None:
    """A line an element, over the mesh; its cells are named, and the frequencies of those in the
    panel of frequencies. The mesh of the scene's `body` is bold.
    """
    chosen = dataset["study"].values == "mesh"
    error = dataset["error"].sel(question=question).values
    seconds = dataset["seconds"].sel(question="response").values
    element, columns, rows = (dataset[name].values for name in ("element", "columns", "rows"))
    for number, kind in enumerate(dict.fromkeys(element[chosen])):
        index = np.flatnonzero(chosen & (element == kind))
        index = index[np.argsort(seconds[index])]
        order = observed_order(
            1 / columns[index],
            error[index],
            floor=float(dataset["reference_error"].sel(question=question)),
            ceiling=50.0,
        )
        panel.plot(
            seconds[index],
            error[index],
            label=f"{kind}: order {order:.2f} in the cells along the length",
            **style.look(number),
        )
        for at in index[np.isfinite(error[index])]:
            text = f"{columns[at]:.0f} x {rows[at]:.0f}"
            if question == "frequency":
                text += f": {dataset['first_frequency'].values[at]:.1f} rad/s"
            own = (kind, [columns[at], rows[at]]) == (body.get("element"), body.get("cells"))
            panel.annotate(
                text + own * ", this scene",
                (seconds[at], error[at]),
                textcoords="offset points",
                xytext=(4, 4),
                fontsize=6,
                weight="bold" if own else "normal",
            )
    panel.margins(x=0.35, y=0.12)
    panel.set(xlabel="wall time of a forced run on this mesh [s]")
