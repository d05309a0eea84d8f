"""Hard cases in pictures: which part of the seeds failed at each forcing and frequency, and the
energy of decays from beyond the training range.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.artefacts.data import FINISHED
from vibrom.report.figures import panels, style
from vibrom.report.stability import was_asked
from vibrom.studies.grid import KINDS
from vibrom.thesis import published as thesis


def asked(collection, scene: str) -> dict[str, list]:
    """Method -> what its seeds answered."""
    found = {
        method: [
            collection.find(scene, method, "stability", seed)
            for seed in collection.seeds(scene, method)
        ]
        for method in collection.methods
    }
    return {
        method: answers for method, answers in found.items() if answers and answers[0] is not None
    }


def failures(collection, scores, scene) -> Figure:
    """A row a method, a column a guard; first integrator."""
    answers = asked(collection, scene)
    guards = (
        [str(guard) for guard in next(iter(answers.values()))[0]["guard"].values] if answers else []
    )
    figure, axes = panels.grid(
        max(1, len(answers) * len(guards)),
        columns=max(1, len(guards)),
        size=(2.5, 1.35),
        legend=0.5,
        sharex=True,
        sharey=True,
    )
    image = None
    for row, (method, seeds) in enumerate(answers.items()):
        for column, guard in enumerate(guards):
            panel = axes[row * len(guards) + column]
            whole = [
                answer.isel(integrator=0, run=answer["kind"].values == KINDS[0]).sel(guard=guard)
                for answer in seeds
            ]
            map_ = [part for part in whole if was_asked(part)]
            if not map_:
                panel.set_title(f"{thesis.label(method)}, {guard}", fontsize=6)
                panels.words(panel, str(whole[0]["outcome"].values[0]))
                continue
            frequency, forcing = (
                np.unique(map_[0]["frequency"].values),
                np.unique(map_[0]["forcing"].values),
            )
            shape = (len(forcing), len(frequency))
            lost = np.mean(
                [~np.isin(part["outcome"].values, FINISHED) for part in map_], axis=0
            ).reshape(shape)
            outside = (
                np.mean([part["outcome"].values == "left_range" for part in map_], axis=0).reshape(
                    shape
                )
                > 0.5
            )
            image = panel.imshow(
                lost,
                origin="lower",
                aspect="auto",
                cmap="Reds",
                vmin=0.0,
                vmax=1.0,
                extent=(-0.5, len(frequency) - 0.5, -0.5, len(forcing) - 0.5),
            )
            panel.plot(*np.nonzero(outside)[::-1], ".", color="0.45", markersize=2.2)
            panel.grid(False)
            ticks = np.linspace(0, len(frequency) - 1, min(4, len(frequency))).astype(int)
            panel.set_xticks(ticks, [f"{frequency[tick]:.3g}" for tick in ticks])
            panel.set_yticks(range(len(forcing)), [f"{level:g}" for level in forcing])
            panel.set_title(
                f"{thesis.label(method)}, {guard}: {lost.sum() * len(map_):.0f} of {lost.size * len(map_)} failed",
                fontsize=6,
            )
            if column == 0:
                panel.set_ylabel("forcing [of the scene's]", fontsize=6)
            if row == len(answers) - 1:
                panel.set_xlabel("frequency [of the first]", fontsize=6)
    if image is None:
        panels.words(axes[0], "no hard cases in this run")
    else:
        figure.colorbar(
            image,
            ax=axes,
            location="bottom",
            shrink=0.4,
            aspect=40,
            label="part of the seeds that failed",
        )
    return figure


def energy(collection, scores, scene) -> Figure:
    """A panel a method: the median seed's decays, one line a release and guard."""
    answers = asked(collection, scene)
    figure, axes = panels.grid(max(1, len(answers)), columns=3, size=(3.0, 2.2), legend=0.4)
    handles = {}
    for panel, method in zip(axes, answers):
        seed, answer = panels.drawn(collection, scores, scene, method, "stability")
        for place, guard in enumerate(answer["guard"].values):
            values = answer["energy"].sel(guard=guard).values
            lines = panel.semilogy(
                np.arange(1, values.shape[1] + 1),
                np.where(values > 0, values, np.nan).T,
                **style.look(place, marker="", linewidth=0.7),
            )
            handles.setdefault(str(guard), lines[0])
            gone = int((~np.isfinite(values[:, -1])).sum())
            if gone and was_asked(answer.isel(integrator=0).sel(guard=guard)):
                panels.words(
                    panel,
                    f"{guard}: {gone} of {len(values)} decays failed",
                    place="above" if place == 0 else "below",
                )
        panel.set(
            title=panels.title(method, seed),
            xlabel="time after release [periods]",
            ylabel="energy [J]",
        )
    if handles:
        figure.legend(
            list(handles.values()), list(handles), loc="outside lower center", ncols=len(handles)
        )
    else:
        panels.words(axes[0], "no hard cases in this run")
    return figure
