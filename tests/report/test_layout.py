"""Words keep off the data and off one another, whatever there is to say; and what is wrong with a
figure is found.
"""

import matplotlib
import numpy as np
import pytest
from legible import faults

from vibrom.report.drawing import layout, style


@pytest.fixture(autouse=True)
def printed():
    """As figures are made."""
    with matplotlib.rc_context(style.STYLE):
        yield


def finished(figure):
    """Laid out as `figures.make` does."""
    layout.finish(figure)
    figure.draw_without_rendering()
    layout.place(figure)
    return figure


@pytest.mark.parametrize("least", [1.15, 1.6, layout.COLUMN])
def test_long_words_keep_off_the_data_and_off_one_another(least):
    figure, axes = layout.grid(4, least=least)
    x, handles = np.linspace(0, 1, 50), {}
    for number, panel in enumerate(axes):
        panel.set(title="Equations (corrected), seed 2: 0.00123 %", xlabel="forcing [N]")
        panel.set_ylabel("response curve: error [%]")
        for index in range(13):
            line = panel.plot(x, np.sin(9 * x + index), **style.look(index))
            handles[f"Equations (corrected) {index}"] = line[0]
        for place in range(number):
            layout.words(panel, f"method {place}: left its training range at 0.000126 s")
        for place in (10, 25, 40):
            layout.name(panel, f"T/{place}00", (x[place], np.sin(9 * x[place])))
    layout.heading(figure, "No loss history, nothing is trained by epochs: " + "SSMLearn 11, " * 9)
    layout.legend(figure, handles.values(), handles)
    assert faults(finished(figure)) == []


def test_panels_are_of_the_height_that_was_asked_for():
    """Whatever stands above and below: within a fifth, as words are measured by their letters."""
    for height in (0.7, 1.4):
        figure, axes = layout.grid(4, height=height)
        for panel in axes:
            panel.set(title="SPLIT", xlabel="time [s]", ylabel="probe [m]")
            panel.plot([0, 1], label="full order")
        layout.words(axes[0], "diverged at 0.126 s")
        layout.legend(figure, *layout.of_panels(figure))
        size = finished(figure).get_figheight() * axes[0].get_position().height
        assert abs(size - height) < 0.2 * height


@pytest.mark.parametrize("scale", ["linear", "log"])
def test_panels_that_share_an_axis_keep_its_numbers(scale):
    """Those without numbers of their own do not take them from the others."""
    figure, axes = layout.grid(4, sharex=True, sharey=True)
    for panel in axes:
        panel.set(xscale=scale, yscale=scale, xlabel="time [s]", ylabel="probe [m]")
        panel.plot([1.0, 1000.0], [1.0, 1000.0])
    finished(figure)
    for axis in (axes[2].xaxis, axes[0].yaxis):
        assert (
            sum(bool(text.get_visible() and text.get_text()) for text in axis.get_ticklabels()) > 1
        )


def test_a_label_stands_once_in_a_row_and_a_column():
    figure, axes = layout.grid(3)
    for panel, words in zip(axes, ("time [s]", "time [s]", "frequency [Hz]")):
        panel.set(xlabel=words, ylabel="probe [m]")
    finished(figure)
    assert [panel.xaxis.label.get_visible() for panel in axes] == [True, True, True]
    assert [panel.yaxis.label.get_visible() for panel in axes] == [True, False, True]


def test_a_note_of_an_empty_panel_stands_in_it():
    figure, (panel,) = layout.grid(1)
    layout.words(panel, "no branches in this run")
    finished(figure)
    (note,) = panel.texts
    box, inside = note.get_window_extent(), panel.get_window_extent()
    assert inside.contains(box.x0, box.y0) and inside.contains(box.x1, box.y1)


def test_what_is_wrong_is_found():
    figure, (panel,) = layout.grid(1)
    panel.plot([0, 1], [0, 1])
    panel.text(0.5, 0.5, "on the line", ha="center", va="center")
    panel.text(0.1, 0.8, "small", fontsize=5.5)
    panel.text(0.8, 0.2, "one")
    panel.text(0.81, 0.2, "other")
    panel.text(0.9, 0.5, "beyond the right edge of the column")
    panel.texts[-1].set_in_layout(False)
    figure.set_size_inches(3.8, 10.0)
    found = "\n".join(faults(finished(figure)))
    for said in (
        "inches wide",
        "inches tall",
        "'on the line' over a line",
        "'small': 5.5 points",
        "'one' over 'other'",
        "'beyond the right edge of the column': outside, to the side",
    ):
        assert said in found, said
