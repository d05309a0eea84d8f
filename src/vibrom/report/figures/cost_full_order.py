"""Work and precision of the full order

Error over wall time for time steps of T/N and residuals (top), and for meshes (bottom). The
legend has the observed orders: two without numerical damping, one with it, because the damping of
a step is proportional to alpha h, and one again where the first acceleration is zero. Bilinear
elements lock in shear when the body bends: the scene's own mesh is bold. Dotted: the estimated
error of the reference.
"""

from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from vibrom.artefacts.outcome import Outcome
from vibrom.report import cost
from vibrom.report.collection import FULL_ORDER, described
from vibrom.report.drawing import layout, panels, style
from vibrom.report.drawing.cost import NOT_STUDIED
from vibrom.report.plots import Panel, Series
from vibrom.studies.parts.work_precision import observed_order

FAMILY = "cost"
PLACE = 610
EACH = "scene"
DATA = ("cost_full_order",)
GLANCE = True
CONVERGED = 15.0  # %: larger errors are not yet those of the leading order
ERRORS = {
    "decay": "decay: NMTE [%]",
    "forced": "forced run, last period: NMTE [%]",
    "frequency": "first frequency: error [%]",
    "response": "forced amplitude: error [%]",
}


def draw(collection, scores, scene) -> Figure:
    """Four panels: of time steps, then of meshes."""
    dataset = cost.studied(collection, "cost_full_order").get(scene)
    figure, axes = layout.grid(len(ERRORS), least=layout.COLUMN, height=0.85)
    for panel in axes:
        panel.set(xlabel="wall time of one run [s]", ylabel="error [%]", xscale="log", yscale="log")
    axes[0].set_title(scene)
    if dataset is None:
        layout.words(axes[0], NOT_STUDIED)
        return figure
    structure = collection.find(scene, FULL_ORDER, "structure")
    for question, panel in zip(ERRORS, axes):
        panel.set(ylabel=ERRORS[question])
        part = dataset.sel(question=question)
        if question in ("decay", "forced"):
            time_steps(panel, part, question)
            residuals(panel, part)
        else:
            part = part.assign(seconds=dataset["seconds"].sel(question="response"))
            meshes(panel, part, question, described(structure, "body"))
        mark_reference(panel, float(part["reference_error"]))
        layout.legend_below(panel)
        panels.decades(panel.xaxis)
        panels.decades(panel.yaxis)
    return figure


def mark_reference(panel, error: float) -> None:
    """Below its own error the reference says nothing."""
    words = {"label": "error of the reference itself"}
    panel.axhline(error, color="0.6", linewidth=0.8, linestyle=":", **words)


def time_steps(panel, part: xr.Dataset, question: str) -> None:
    """A line a scheme, over the time step."""
    schemes: dict = {}
    for index in np.flatnonzero(part["study"].values == "step"):
        names = ("scheme", "alpha", "initial_acceleration")
        scheme = tuple(part[name].values[index] for name in names)
        schemes.setdefault(scheme, []).append(index)
    drawn: set = set()
    for (scheme, alpha, start), indices in schemes.items():
        if question == "forced" and (scheme, alpha) in drawn:
            continue  # from rest every start is the same
        drawn.add((scheme, alpha))
        chosen = part.isel(setting=indices)
        words = cost.scheme_words(scheme, alpha)
        if question == "decay":
            words += f", a(0) {'of the equation' if start == 'equilibrium' else 'zero'}"
        look = style.look(len(drawn) + (start == "zero"))
        panel.plot(*points(chosen), label=f"{words}: {order(chosen)}", **look)
        if len(drawn) == 1 and start == "equilibrium":
            for one in (chosen.isel(setting=at) for at in range(len(indices))):
                if np.isfinite(one["error"]):
                    steps = f"T/{int(one['steps_per_period'])}"
                    layout.name(panel, steps, points(one))


def points(part: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Seconds, and error in percent."""
    return part["seconds"].values, part["error"].values


def order(chosen: xr.Dataset) -> str:
    """Observed order of the time step, and the steps with which Newton's iteration fails."""
    steps, floor = chosen["steps_per_period"].values, 5 * float(chosen["reference_error"])
    error = chosen["error"].values
    observed = observed_order(1 / steps, error, floor=floor, ceiling=CONVERGED)
    stopped = [
        f"T/{number:.0f}"
        for number, word in zip(steps, chosen["outcome"].values)
        if Outcome(word) is Outcome.NO_CONVERGENCE
    ]
    return f"order {observed:.2f}" + (
        f"; no convergence at {', '.join(stopped)}" if stopped else ""
    )


def residuals(panel, part: xr.Dataset) -> None:
    """Markers over the residual at which a step has converged."""
    chosen = part.isel(setting=np.flatnonzero(part["study"].values == "residual"))
    good = chosen["residual"].values[np.isfinite(chosen["error"].values)]
    if good.size:
        steps = f"T/{chosen['steps_per_period'].values[0]:.0f}, α = 0"
        words = f"residual {good.max():.0e} to {good.min():.0e} at {steps}"
        look = style.look(6, linestyle="none")
        panel.plot(*points(chosen), label=words, **look)


def meshes(panel, part: xr.Dataset, question: str, body: dict) -> None:
    """A line an element, over the mesh; its cells are named, and the frequencies of those in the
    panel of frequencies. The mesh of the scene's `body` is bold.
    """
    part = part.isel(setting=np.flatnonzero(part["study"].values == "mesh"))
    floor = float(part["reference_error"])
    for number, element in enumerate(dict.fromkeys(part["element"].values)):
        chosen = part.isel(setting=np.flatnonzero(part["element"].values == element))
        chosen = chosen.isel(setting=np.argsort(chosen["seconds"].values))
        size, error = 1 / chosen["columns"].values, chosen["error"].values
        observed = observed_order(size, error, floor=floor, ceiling=50.0)
        words = f"{element}: order {observed:.2f} in the cells along the length"
        panel.plot(*points(chosen), label=words, **style.look(number))
        for one in (chosen.isel(setting=at) for at in range(chosen.sizes["setting"])):
            if np.isfinite(one["error"]):
                name_mesh(panel, one, question, body)
    panel.margins(x=0.35, y=0.12)
    panel.set(xlabel="wall time of a forced run on this mesh [s]")


def name_mesh(panel, one: xr.Dataset, question: str, body: dict) -> None:
    """Beside its marker; that of the scene is bold."""
    cells = [int(one["columns"]), int(one["rows"])]
    text = f"{cells[0]} x {cells[1]}"
    if question == "frequency":
        text += f": {float(one['first_frequency']):.1f} rad/s"
    own = (str(one["element"].values), cells) == (body.get("element"), body.get("cells"))
    weight = "bold" if own else "normal"
    text += ", this scene" if own else ""
    layout.name(panel, text, points(one), weight=weight)


def plot(collection, scores) -> list[Panel]:
    """A line a scheme over its time steps T/N, or an element over its meshes; which one is under
    the pointer. Errors are against the same mesh with a fine step, or against the finest mesh.
    """
    made = []
    for scene, dataset in cost.studied(collection, "cost_full_order").items():
        for question, words in ERRORS.items():
            part, of_mesh = dataset.sel(question=question), question in ("frequency", "response")
            if of_mesh:
                part = part.assign(seconds=dataset["seconds"].sel(question="response"))
            lines = []
            for index, (name, chosen) in enumerate(groups(part, of_mesh)):
                x, y = points(chosen)
                look = style.look(index) | {"linewidth": 1.2}
                notes = [setting(chosen.isel(setting=at)) for at in range(chosen.sizes["setting"])]
                line = {"mode": "lines+markers", "name": name, "notes": notes, "look": look}
                lines.append(Series(FULL_ORDER, x, y, **line))
            what = words.partition(":")[0]
            title = f"{scene}, {what}{', meshes' if of_mesh else ''}"
            axis = "wall time of one run [s]"
            made.append(Panel(title, axis, words, lines, log="xy", switch="xy"))
    return made


def groups(part: xr.Dataset, of_mesh: bool) -> Iterator[tuple[str, xr.Dataset]]:
    """The settings of each scheme or element, by their seconds."""
    part = part.isel(
        setting=np.flatnonzero(part["study"].values == ("mesh" if of_mesh else "step"))
    )
    named = [
        str(one["element"].values)
        if of_mesh
        else f"{cost.scheme_words(str(one['scheme'].values), float(one['alpha']))}, "
        f"a(0) {one['initial_acceleration'].values}"
        for one in (part.isel(setting=at) for at in range(part.sizes["setting"]))
    ]
    for name in dict.fromkeys(named):
        chosen = part.isel(setting=[at for at, other in enumerate(named) if other == name])
        yield name, chosen.isel(setting=np.argsort(chosen["seconds"].values))


def setting(one: xr.Dataset) -> str:
    """What was set."""
    if str(one["study"].values) == "mesh":
        return f"{int(one['columns'])} x {int(one['rows'])} cells"
    return f"T/{int(one['steps_per_period'])}"
