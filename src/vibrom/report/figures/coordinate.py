"""Does the motion fold over its linear coordinate?

Left, the modal coordinate phi_1'M q in the first two periods of the training decay: where it grows
on the way from a turning point to rest, it passes one value twice. Middle, what the largest
coordinate that is passed twice hides: the shapes at two such instants, or, where there are none,
the shape at the release. Right, how well the unseen decay is reconstructed: dots, by polynomials of
growing order over the modal coordinate and its rate, fitted to the training decay by least squares;
lines, by the coordinates of each method (median over seeds). Polynomials over a coordinate that is
passed twice stay apart from the motion at any order.
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from vibrom.latent.polynomial import exponents, least_squares, monomials
from vibrom.models.decoded import decoded
from vibrom.models.measures import nmte_percent
from vibrom.models.recorded import structure, trajectory
from vibrom.models.samples import Samples
from vibrom.models.training import MethodError
from vibrom.report.collection import FULL_ORDER
from vibrom.report.columns import number
from vibrom.report.drawing import body, layout, style
from vibrom.thesis.labels import label

FAMILY = "models"
PLACE = 445
EACH = "scene"
DATA = ("reconstruction", "{scene}/full_order/train.nc")

PERIODS = 2  # that are drawn
ORDERS = (1, 3, 5, 7, 9, 11)


def draw(collection, scores, scene) -> Figure:
    """Three panels."""
    figure, (coordinate, shapes, errors) = layout.grid(3, least=layout.COLUMN, height=1.25)
    known = collection.mesh(scene)
    train, test = (collection.find(scene, FULL_ORDER, name) for name in ("train", "test"))
    coordinate.set(xlabel="time [s]", ylabel="modal coordinate [m √kg]", title=scene)
    shapes.set(**body.labels(known), aspect="equal")
    errors.set(
        xlabel="order of the polynomials [1]", ylabel="reconstruction NMTE [%]", yscale="log"
    )
    runs = [run for run in (train, test) if run is not None and finite(run)]
    if known is None or len(runs) < 2:
        layout.words(coordinate, "no body or recorded decays in this run")
        return figure
    train, test = runs
    operators = structure(known)
    weight = operators.mass @ operators.leading(1)[0]
    shown = train["time"].values - train["time"].values[0] < PERIODS * float(train["period"])
    z = projected(train, weight)
    coordinate.plot(train["time"].values[shown], z[shown], color="#004c7a")
    pair = passed_twice(z[shown])
    for place, at in enumerate(pair or [0]):
        colour = style.COLOURS[place]
        coordinate.plot(train["time"].values[at], z[at], "o", color=colour, markersize=4)
        for loop in body.outlines(known, train["displacement"][at].values):
            shapes.plot(*loop.T, color=colour, linewidth=0.9)
    layout.words(coordinate, "passed twice" if pair else "passed once")
    found = by_order(*(trajectory(run, lazy=True) for run in runs), weight)
    errors.plot(*zip(*found), "o-", color="black", markersize=3, label="polynomials")
    for place, method in enumerate(collection.methods):
        error = scores.spread(scene, method, "reconstruction", "nmte_percent", worst=True).median
        if np.isfinite(error):
            look = {"color": style.COLOURS[place % len(style.COLOURS)], "linewidth": 0.9}
            dash = style.DASHES[place % len(style.DASHES)]
            errors.axhline(error, **look, linestyle=dash, label=label(method))
    layout.legend(figure, *layout.of_panels(figure))
    return figure


def seen(collection, scores, scene) -> str:
    """Whether the coordinate is passed twice, and how well each method's coordinates do."""
    known, train = collection.mesh(scene), collection.find(scene, FULL_ORDER, "train")
    if known is None or train is None or not finite(train):
        return "No body or recorded decays in this run."
    operators = structure(known)
    z = projected(train, operators.mass @ operators.leading(1)[0])
    shown = train["time"].values - train["time"].values[0] < PERIODS * float(train["period"])
    passed = "twice" if passed_twice(z[shown]) else "once"
    errors = {
        label(method): scores.spread(
            scene, method, "reconstruction", "nmte_percent", worst=True
        ).median
        for method in collection.methods
    }
    words = [f"{name} {number(value, 3)} %" for name, value in errors.items() if value < np.inf]
    return f"The coordinate passes its values {passed}. Errors: {', '.join(words) or 'none'}."


def finite(run) -> bool:
    """Did the decay last?"""
    return Samples(((run["displacement"].variable,),)).all(np.isfinite)


def projected(run, weight: np.ndarray) -> np.ndarray:
    """q'w (m,) of recorded displacements."""
    return Samples(((run["displacement"].variable,),)) @ weight


def passed_twice(z: np.ndarray) -> list[int] | None:
    """Two instants between the first turning point and rest at which the coordinate is the same,
    the first of them the release; None where it only falls.
    """
    side = np.sign(z[0]) * z
    rest = int(np.argmax(side < 0.0)) or len(side)
    top = int(side[:rest].argmax())
    if side[top] <= (1.0 + 1e-3) * side[0]:
        return None
    return [0, top + int(np.argmax(side[top:rest] <= side[0]))]


@dataclass(frozen=True)
class Graph:
    """Displacements that are linear in what stands for the coordinates."""

    shape: np.ndarray  # (n, terms)

    @property
    def size(self) -> int:
        """n."""
        return len(self.shape)

    def decoded(self, coordinates: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        """See `Decoder`."""
        return coordinates @ self.shape[slice(None) if dofs is None else dofs].T


def by_order(train, test, weight: np.ndarray) -> list[tuple[int, float]]:
    """(order, NMTE [%]) of the unseen decay, of polynomials in the coordinate and its rate."""
    y = [
        np.stack([Samples(((part,),)) @ weight for part in run.columns("state")], axis=1)
        for run in (train, test)
    ]
    reach = np.abs(y[0]).max(axis=0)
    found = []
    for order in ORDERS:
        powers = exponents(2, 1, order)
        library, unseen = (monomials(part / reach, powers) for part in y)
        try:
            shape = least_squares(library, Samples(((train.displacement,),)))
        except MethodError:
            break  # more terms than samples
        shown = decoded(Graph(shape), unseen[None])[0][0]
        found.append((order, nmte_percent(test.displacement, shown)))
    return found
