"""Figures: failures and absent datasets in words, one look a method, the same bytes twice."""

from pathlib import Path

import matplotlib
import numpy as np
import pytest
import xarray as xr
from small_run import altered

from vibrom.artefacts.data import outcome_variables
from vibrom.report import figures, outputs
from vibrom.report.collection import Collection, Key
from vibrom.report.drawing import body, style
from vibrom.report.drawing.states import State, states
from vibrom.report.figures import blow_up
from vibrom.steps import output
from vibrom.thesis.labels import KNOWN


@pytest.fixture(scope="module")
def drawn(collection, scores):
    """Figures by name, each drawn once."""
    found = {}

    def draw(name):
        if name not in found:
            found[name] = figures.make(name, collection, scores)
        return found[name]

    return draw


def words(figure) -> str:
    """All of its text."""
    parts = [figure, *figure.subfigs]
    written = [text.get_text() for axes in figure.axes for text in axes.texts]
    inside = [" ".join(text.split()) for text in written]  # as on one line
    titles = [" ".join(axes.get_title(loc="left").split()) for axes in figure.axes]
    return "\n".join([*inside, *titles, *(" ".join(part.get_suptitle().split()) for part in parts)])


def test_failures_are_in_words_in_their_panel(drawn):
    # Modal projection has one run, and it failed; of split a seed that did not fail may be drawn.
    assert "diverged at 0.011 s" in words(drawn("forced_large"))
    assert "diverged" not in words(drawn("forced_small"))
    assert "Modal projection: 6 of 9; diverged" in words(drawn("frc_amplitude"))
    assert "diverged" in words(drawn("final_shapes_large"))
    assert "Modal projection in case large" in words(drawn("blow_up"))
    assert "after" in words(drawn("blow_up"))


def test_an_implicit_method_that_does_not_converge_is_a_failure():
    run = xr.Dataset(outcome_variables("no_convergence", 0.1))
    key = Key("large", "split", 0, "forced")
    assert blow_up.first_failure(Collection({key: lambda: run}))[:3] == key[:3]
    left = xr.Dataset(outcome_variables("left_range", 0.1))
    assert blow_up.first_failure(Collection({key: lambda: left})) is None


@pytest.mark.parametrize("name", ["decay_large", "forced_large", "phase_portraits_large"])
@pytest.mark.parametrize("other", ["final_shapes_large", "backbones", "frc_phase"])
def test_a_model_that_could_not_be_fitted_says_why(collection, scores, name, other):
    kept = [key for key in collection.loaders if key[:3] != ("large", "split_plus", 0)]
    part = Collection({key: collection.loaders[key] for key in kept})
    for figure in (name, other):
        text = words(figures.make(figure, part, scores)).replace("\n", " ")
        assert "the training diverged: the loss is" in text, figure


def test_effects_that_cannot_be_left_out_say_who_needs_them(drawn):
    text = words(drawn("ablation_small"))
    assert "needed by modal load, inertia" in text and "did not converge" in text
    assert "without damping: decay NMTE 16 %" in text
    # Decay, forced run and seconds: of the others there is nothing to draw.
    assert len(drawn("ablation_small").axes) == 3


def test_panels_name_the_method_and_the_seed_that_is_drawn(drawn, scores):
    text = words(drawn("decay_small"))
    for method, label in (("split", "SPLIT"), ("split_plus", "SPLIT+")):
        seed = scores.median_seed("small", method, [0, 1])
        error = scores.value("small", method, seed, "decay", "nmte_percent")
        assert f"{label}, seed {seed}: {error:.3g} %" in text
    assert "Modal projection: " in text


def test_methods_without_epochs_are_named(drawn):
    assert "Modal projection" in words(drawn("losses_small"))
    assert len(drawn("losses_small").axes) >= 1


def test_one_method_is_told_from_another_without_colour(drawn):
    for name in ("frc_amplitude", "frc_phase"):
        for axes, count in zip(drawn(name).axes, (4, 4)):
            looks = [(str(line._dash_pattern), line.get_marker()) for line in axes.lines]
            assert len(set(looks)) == len(looks) >= count - 1, name


def test_a_method_looks_alike_whichever_others_run():
    every = style.looks([*KNOWN, "my_method", "another"])
    for methods in (["split"], ["split", "my_method"], ["another", "split"], [*KNOWN, "my_method"]):
        assert style.looks(methods) == {method: every[method] for method in methods}


def test_no_two_methods_look_alike():
    for count in (1, 20, style.LOOKS - len(KNOWN)):
        methods = [*KNOWN, *(f"method_{number}" for number in range(count))]
        found = style.looks(methods).values()
        assert len({(str(look["linestyle"]), look["marker"]) for look in found}) == len(methods)


def test_markers_alone_tell_the_methods_of_a_run_apart_without_colour():
    found = [
        (look["marker"], look["markerfacecolor"] == "white") for look in style.looks(KNOWN).values()
    ]
    assert len(set(found)) == len(KNOWN) <= 2 * len(style.MARKERS)


def test_release_states_shared_by_scenes_are_drawn_once(collection):
    own = [["small test"], ["small train"], ["large test"], ["large train"]]
    assert sorted(state.used for state in states(collection)) == sorted(own)
    small = collection.loaders[Key("small", "full_order", None, "release")]
    same = altered(collection, {("large", "full_order", None, "release"): lambda _: small()})
    shared = [["small test", "large test"], ["small train", "large train"]]
    assert sorted(state.used for state in states(same)) == sorted(shared)


def test_release_states_show_the_probes_that_there_are():
    """The first one, and the one called tip."""
    for names, shown in ((["above", "side"], {"above": 0.2}), (["tip"], {"tip": 0.2})):
        dofs = xr.Dataset({"probe_dof": ("probe", [1, 0][: len(names)])}, {"probe": names})
        assert State(dofs, np.array([0.1, 0.2]), []).shown == shown


def test_a_body_under_a_dead_load_is_drawn_about_its_equilibrium(collection):
    structure = collection.find("small", "full_order", "structure")
    size = structure.sizes["dof"]
    sagged, moved = np.linspace(0.0, -0.1, size), np.linspace(0.0, 0.02, size)
    under_load = structure.assign(equilibrium=("dof", sagged))
    for draw in (
        lambda *given: body.polygons(*given)[0],
        lambda *given: np.concatenate(body.outlines(*given)),
    ):
        np.testing.assert_allclose(
            draw(under_load, moved), draw(structure, sagged + moved), atol=1e-15
        )


def test_outline_of_a_beam_is_one_closed_loop(collection):
    loops = body.outline(collection.find("small", "full_order", "structure"))
    assert len(loops) == 1 and len(loops[0]) == 2 * (8 + 2) + 1 and loops[0][0] == loops[0][-1]


def test_mid_side_nodes_of_quadratic_elements_move_no_corner(collection):
    structure = collection.find("small", "full_order", "structure")
    free, dof_node = np.ones(structure.sizes["dof"]), structure["dof_node"].copy()
    dof_node[3:5] = -1
    moved = body.displacement(structure.assign(dof_node=dof_node), free)
    assert moved.sum() == structure.sizes["dof"] - 2


def test_all_formats_and_the_same_bytes_twice(small, tmp_path):
    chosen = ["backbones", "blow_up", "configurations"]
    written = []
    for folder in ("first", "second"):
        paths = [
            str(tmp_path / folder / f"{name}.{form}")
            for name in chosen
            for form in outputs.FORMATS["figures"]
        ]
        output.run(
            kind="figures",
            artefacts=small.paths,
            outputs=paths,
            provenance={"source_digest": "feed"},
        )
        written.append([Path(path).read_bytes() for path in paths])
    assert written[0] == written[1]
    for content in written[0][::3]:
        assert content.startswith(b"<?xml") and b"feed" in content
    assert all(content.startswith(b"%PDF") for content in written[0][1::3])
    assert all(content.startswith(b"\x89PNG") for content in written[0][2::3])


def test_tables_of_an_earlier_run_go_where_they_are_not_asked_for(small, tmp_path):
    for name in ("frc.csv", "frc.tex", "mine.csv"):
        (tmp_path / name).write_text("of before")
    given = {"artefacts": small.paths, "provenance": {"source_digest": "feed"}}
    paths = [str(tmp_path / f"beam.{form}") for form in outputs.FORMATS["tables"]]
    output.run(kind="tables", outputs=paths, not_asked=["frc", "branches"], **given)
    there = {path.name for path in tmp_path.iterdir()}
    assert there == {"mine.csv", *(Path(path).name for path in paths)}


def test_a_figure_that_does_not_exist_is_refused_by_name():
    with pytest.raises(ValueError, match="'decays': unknown"):
        outputs.drawing("decays", ["small"])
    assert outputs.drawing("decay_small", ["small"]) == ("decay", "small")
    assert outputs.drawing("frc_phase", ["phase"]) == ("frc_phase", None)


def test_the_user_s_own_style_sheet_changes_no_figure():
    """Text set by LaTeX would need one that is installed."""
    own = {"text.usetex": True, "image.cmap": "hot"}
    with matplotlib.rc_context(own), matplotlib.rc_context(style.STYLE):
        for name in own:
            assert matplotlib.rcParams[name] == matplotlib.rcParamsDefault[name]
