"""Error as training proceeds: each point is a model that was trained for so long; polynomial fits beside them, by order."""

import pandas as pd
from matplotlib.figure import Figure

from vibrom.report import cost, thesis
from vibrom.report.figures import panels, style
from vibrom.report.figures.cost_reduced import ASKED

EPOCHS = ("epochs", "start.epochs")


def draw(collection, scores, scene=None) -> Figure:
    table = cost.settings(cost.reduced(collection))
    known = list(dict.fromkeys(table["case"]))
    figure = Figure(figsize=(8.6, 2.9 * max(1, len(known)) + 0.4))
    axes = figure.subplots(max(1, len(known)), 3, squeeze=False)
    handles: dict = {}
    for panels_of_row in axes:
        for panel, said in zip(panels_of_row, ASKED.values()):
            panel.set(xlabel="fit: mapping and dynamics [s]", ylabel=said, xscale="log", yscale="log")
    if not known:
        panels.words(axes[0, 0], "no scene of this run was studied")
    for row, name in zip(axes, known):
        row[0].set_title(name)
        for panel, question in zip(row, ASKED):
            group = table[(table["case"] == name) & table[f"{question}_error_percent"].notna()]
            for index, method in enumerate(collection.methods):
                mine = series(group[group["method"] == method])
                if len(mine):
                    place = mine["fit_s"].to_numpy(float), mine[f"{question}_error_percent"].to_numpy(float)
                    handles[thesis.label(method)] = panel.plot(*place, **style.look(index))[0]
                    for x, y, said in zip(*place, mine["said"]):
                        panel.annotate(said, (x, y), textcoords="offset points", xytext=(3, 3), fontsize=5.5, color="0.35")
            if not len(group):
                panels.words(panel, "no setting has an answer")
    for panel in axes.flat:
        panels.decades(panel.xaxis)
        panels.decades(panel.yaxis)
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=5)
    return figure


def series(mine):
    """Of a method that trains its settings by length of training, with the model of the run; of one that does not those by order. `said` names each."""
    trained = mine[mine["varied"].isin(EPOCHS)]
    if len(trained):
        usual = mine[mine["varied"] == cost.CONFIGURED]
        return pd.concat([trained.assign(said=trained["set_to"]), usual.assign(said="as configured")]).sort_values("fit_s")
    by_order = mine[mine["varied"].str.startswith("order")]
    if len(by_order):
        return by_order.assign(said="p = " + by_order["set_to"])
    usual = mine[mine["varied"] == cost.CONFIGURED]
    return usual.assign(said="")
