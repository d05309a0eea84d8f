"""Tables and figures are found by listing their files, and an edit remakes what shows it."""

import shutil

import pytest

from vibrom.artefacts import provenance
from vibrom.config import plugs, source
from vibrom.report import outputs

TABLE = '''"""My table

What it shows.
"""

FAMILY = "models"
PLACE = 45
COLUMNS = ()
'''


def forget():
    """What was read of the package."""
    for module in (plugs, source, outputs, provenance):
        for item in vars(module).values():
            if hasattr(item, "cache_clear"):
                item.cache_clear()


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A copy of the package to edit."""
    copy = tmp_path / "vibrom"
    shutil.copytree(source.PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(source, "PACKAGE", copy)
    forget()
    yield copy
    monkeypatch.undo()
    forget()


def digests() -> dict[str, str]:
    """Of the rules that make the tables and figures of each family, and of the report."""
    forget()
    found = {
        (kind, family): provenance.digest(
            "vibrom.steps.output",
            f"vibrom.report.{kind}",
            *(f"vibrom.{module}" for module in outputs.modules(kind, family)),
        )
        for kind in outputs.FORMATS
        for family in outputs.families()
    }
    return found | {"report": provenance.digest("vibrom.steps.report")}


def changed(before) -> set:
    """What runs again."""
    after = digests()
    return {name for name in before if before[name] != after[name]}


def rewrite(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def test_families_and_their_outputs_stand_in_reading_order():
    assert outputs.families() == ["models", "cost", "ablation", "robustness", "trust"]
    assert outputs.tables("models")[:4] == ["beam", "eigenvalues", "reconstruction", "decay"]
    assert list(outputs.figures("models", ["a", "b"]))[:2] == ["accuracy_cost", "configurations"]
    assert {"decay_a", "decay_b"} <= set(outputs.figures("models", ["a", "b"]))
    assert set(outputs.also("models")) == {"robustness", "trust"} and outputs.also("cost") == []


def test_an_experiment_without_a_table_of_its_own_has_one_of_its_scores():
    found = outputs.tables("models", ["decay", "backbone"])
    assert found[-1] == "backbone" and found.count("decay") == 1
    assert "backbone" not in outputs.tables("cost", ["backbone"])
    title, (about, how) = outputs.caption("tables", "backbone")
    assert "backbone" in title and "peak finding" in about and "Median over seeds" in how


def test_what_nobody_asked_for_is_not_made():
    every, asked = set(outputs.tables("models")), ["decay", "branches"]
    left = every - set(outputs.tables("models", asked))
    assert left >= {"forced", "frc", "run_times", "s_curve"} and "random_forcing" not in every
    assert not left & {"decay", "branches", "folds", "beam", "checks"}
    drawn = outputs.figures("models", ["a", "b"], asked={"a": asked, "b": ["frc"]}.get)
    assert {"decay_a", "branches_a", "frc_phase"} <= set(drawn)
    assert not {"decay_b", "branches_b", "forced_a", "backbones"} & set(drawn)
    measured = outputs.figures("models", ["a"], recorded=["a"])
    assert "slow_motion_a" in measured and "release_states" not in measured
    both = outputs.figures("models", ["a", "b"], recorded=["a"])
    assert "slow_motion_b" not in both and "release_states" in both
    for name in ("slow_motion_a", "release_states", "decay_b"):
        assert outputs.drawing(name, ["a", "b"]).plug == name.removesuffix("_a").removesuffix("_b")


def test_one_more_table_is_one_file(package):
    (package / "report/tables/mine.py").write_text(TABLE)
    forget()
    found = outputs.tables("models")
    assert found[found.index("decay") + 1] == "mine"
    caption = outputs.caption("tables", "mine")
    assert caption == ("My table", ("What it shows.",))
    assert caption.rst == "**My table**\n\nWhat it shows.\n"


def test_a_file_that_does_not_say_what_it_is_is_named(package):
    path = package / "report/tables/mine.py"
    path.write_text(TABLE.replace("PLACE = 45\n", ""))
    forget()
    with pytest.raises(ValueError, match=r"report/tables/mine\.py: no PLACE"):
        outputs.tables("models")
    path.write_text(TABLE.replace("\n\nWhat it shows.\n", ""))
    forget()
    with pytest.raises(ValueError, match=r"report/tables/mine\.py: no caption"):
        outputs.caption("tables", "mine")


def test_two_figures_of_one_name_are_refused(package):
    shutil.copy(package / "report/figures/decay.py", package / "report/figures/frc.py")
    forget()
    assert "frc_small" in outputs.figures("models", ["small"])
    with pytest.raises(ValueError, match="two figures are called frc_phase"):
        outputs.figures("models", ["phase"])


@pytest.mark.parametrize(
    ("file", "old", "new", "runs"),
    [
        ("figures/decay.py", "LAST = 5", "LAST = 6", {("figures", "models")}),
        ("figures/decay.py", "The vertical axis", "The y axis", set()),  # a caption: the page alone
        ("tables/guards.py", '"Guard"', '"With guard"', {("tables", "robustness")}),
        ("page.py", "HEAVY = ", "HEAVY = 2 * ", {"report"}),
    ],
)
def test_an_edit_remakes_its_family_alone(package, file, old, new, runs):
    before = digests()
    rewrite(package / "report" / file, old, new)
    assert changed(before) == runs


def test_what_all_figures_share_remakes_no_table(package):
    before = digests()
    rewrite(package / "report/drawing/style.py", '"font.size": ', '"font.size": 1 + ')
    drawings = {("figures", family) for family in outputs.families()}
    assert changed(before) == drawings | {"report"}  # whose plots look alike
