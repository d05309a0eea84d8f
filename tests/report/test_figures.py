"""Figures: units on every axes, failures and absent datasets in words, all formats, the same bytes
twice.
"""

import re

import numpy as np
import pytest
import xarray as xr

from vibrom.artefacts.data import outcome_variables
from vibrom.report import names
from vibrom.report.collection import Collection
from vibrom.report.figures import blow_up, draw
from vibrom.report.scores import Scores
from vibrom.steps import figures as step

FIGURES = names.figures(["small", "large"], "models", "cost", "effects")
UNITS = re.compile(r"\[[^\]]+\]")


@pytest.fixture(scope="module")
def drawn(collection, scores):
    return {name: draw(name, collection, scores) for name in FIGURES}


def said(figure) -> str:
    parts = [figure, *figure.subfigs]
    inside = [text.get_text() for axes in figure.axes for text in axes.texts]
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    return "\n".join([*inside, *titles, *(part.get_suptitle() for part in parts)])


@pytest.mark.parametrize("name", FIGURES)
def test_every_axes_says_what_it_shows_in_which_unit(drawn, name):
    assert drawn[name].axes
    for axes in drawn[name].axes:
        labels = (
            [axes.get_ylabel()]
            if axes.get_label() == "<colorbar>"
            else [axes.get_xlabel(), axes.get_ylabel()]
        )
        for label in labels:
            assert UNITS.search(label), f"{name}: axis labelled {label!r}"


def test_failures_are_in_words_in_their_panel(drawn):
    # Modal projection has one run, and it failed; of split a seed that did not fail is drawn.
    assert said(drawn["forced_large"]).count("diverged at 0.0471 s") == 1
    assert "diverged" not in said(drawn["forced_small"])
    assert "Modal projection: 6 of 9; diverged" in said(drawn["frc_amplitude"])
    assert "diverged" in said(drawn["final_shapes"])
    assert "Modal projection in case large" in said(drawn["blow_up"]) and "after 3 periods" in said(
        drawn["blow_up"]
    )


def test_an_implicit_method_that_does_not_converge_is_a_failure():
    run = xr.Dataset(outcome_variables("no_convergence", 0.1))
    assert blow_up.first_failure(Collection({("large", "split", "seed_0", "forced"): lambda: run}))[
        :3
    ] == ("large", "split", "seed_0")


@pytest.mark.parametrize(
    "name",
    [
        "decay_large",
        "forced_large",
        "phase_portraits_large",
        "final_shapes",
        "backbones",
        "frc_phase",
    ],
)
def test_a_model_that_could_not_be_fitted_says_why(collection, scores, name):
    other = ("large", "split_plus", "seed_0")
    loaders = {key: loader for key, loader in collection.loaders.items() if key[:3] != other}
    words = said(draw(name, Collection(loaders), scores)).replace("\n", " ")
    assert "training diverged: the loss became infinite in epoch 7" in words


def test_effects_that_cannot_be_left_out_say_who_needs_them(drawn):
    words = said(drawn["effects_small"])
    assert (
        "needed by modal load" in words
        and "without rayleigh damping: decay NMTE 16 %" in words
        and "no convergence" in words
    )
    assert (
        len(drawn["effects_small"].axes) == 3
    )  # decay, forced run and seconds: of the others there is nothing to draw


def test_panels_name_the_method_and_the_seed_that_is_drawn(drawn):
    words = said(drawn["decay_small"])
    assert (
        "SPLIT, seed 0: 3 %" in words
        and "SPLIT+, seed 1: 1 %" in words
        and "Modal projection: 1.5 %" in words
    )


def test_methods_without_epochs_are_named(drawn):
    assert (
        "Modal projection" in said(drawn["losses_large"]) and len(drawn["losses_large"].axes) == 2
    )


def test_one_method_is_told_from_another_without_colour(drawn):
    for name in ("backbones", "frc_amplitude", "frc_phase"):
        for axes in drawn[name].axes:
            looks = [(str(line._dash_pattern), line.get_marker()) for line in axes.lines]
            assert len(set(looks)) == len(looks) == 4, name


def test_release_states_shared_by_scenes_are_drawn_once(collection, scores, tree):
    from vibrom.report.figures.states import states

    found = states(collection)
    assert [state.used for state in found] == [
        ["small test"],
        ["small train"],
        ["large test"],
        ["large train"],
    ]
    loaders = {key: loader for key, loader in collection.loaders.items()}
    loaders["large", "full_order", "unseeded", "release"] = loaders[
        "small", "full_order", "unseeded", "release"
    ]
    shared = states(Collection(loaders))
    assert [state.used for state in shared] == [
        ["small test", "large test"],
        ["small train", "large train"],
    ]


def test_a_body_under_a_dead_load_is_drawn_about_its_equilibrium(collection):
    from vibrom.report.figures.body import outlines, quadrilaterals

    structure = collection.find("small", "full_order", "structure")
    sagged, moved = (
        np.linspace(0.0, -0.1, structure.sizes["dof"]),
        np.linspace(0.0, 0.02, structure.sizes["dof"]),
    )
    under_load = structure.assign(equilibrium=("dof", sagged))
    for drawn in (quadrilaterals, lambda *arguments: np.concatenate(outlines(*arguments))):
        np.testing.assert_allclose(
            drawn(under_load, moved), drawn(structure, sagged + moved), atol=1e-15
        )


def test_outline_of_a_beam_is_one_closed_loop(collection):
    from vibrom.report.figures.body import outline

    loops = outline(collection.find("small", "full_order", "structure"))
    assert len(loops) == 1 and len(loops[0]) == 2 * (8 + 2) + 1 and loops[0][0] == loops[0][-1]


def test_mid_side_nodes_of_quadratic_elements_move_no_corner(collection):
    from vibrom.report.figures.body import displacement

    structure = collection.find("small", "full_order", "structure")
    free, dof_node = np.ones(structure.sizes["dof"]), structure["dof_node"].copy()
    dof_node[3:5] = -1
    moved = displacement(structure.assign(dof_node=dof_node), free)
    assert moved.sum() == structure.sizes["dof"] - 2


def test_all_formats_and_the_same_bytes_twice(tree, tmp_path):
    chosen = ["backbones", "blow_up", "configurations"]
    written = []
    for folder in ("first", "second"):
        paths = [
            str(tmp_path / folder / f"{name}.{form}")
            for name in chosen
            for form in names.FIGURE_FORMATS
        ]
        step.run(
            scores=tree.scores,
            artefacts=tree.artefacts,
            figures=paths,
            provenance={"source_digest": "feed"},
        )
        written.append([open(path, "rb").read() for path in paths])
    assert written[0] == written[1]
    for content in written[0][::3]:
        assert content.startswith(b"<?xml") and b"feed" in content
    assert all(content.startswith(b"%PDF") for content in written[0][1::3])
    assert all(content.startswith(b"\x89PNG") for content in written[0][2::3])


@pytest.mark.parametrize("name", names.figures(["small"], "models", "cost", "effects"))
def test_a_run_with_nothing_but_its_structure_still_has_every_figure(collection, scores, name):
    kept = {
        key: loader for key, loader in collection.loaders.items() if key[3] in ("structure", "rom")
    }
    figure = draw(name, Collection(kept), Scores(scores.frame.iloc[:0]))
    assert said(figure).strip()


def test_a_figure_that_does_not_exist_is_refused_by_name():
    with pytest.raises(ValueError, match="'decays': unknown"):
        names.split("decays")
