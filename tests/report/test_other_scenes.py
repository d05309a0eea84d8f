"""What tables, headline and page leave out where a run has none of the thesis's scenes."""

import re
from dataclasses import replace

import numpy as np
import pytest

from vibrom.artefacts.outcome import Tally
from vibrom.config import plugs
from vibrom.report import answer, headline, outputs, sentences
from vibrom.report import page as page_of
from vibrom.report.columns import CASE, published
from vibrom.report.table import printed, table


@pytest.mark.parametrize(("value", "more"), [(np.nan, []), (2.0, ["Thesis [%]"])])
def test_numbers_of_the_thesis_are_printed_where_there_are_some(value, more):
    columns = (CASE, published("thesis_percent", "Thesis [%]"))
    made = table("errors", columns, [{"case": "mine", "thesis_percent": value}], printed)
    assert made.printed.head == ["Case", *more]
    assert list(made.frame) == ["case", "thesis_percent"]


@pytest.mark.parametrize("value", [np.nan, 2.0])
def test_the_headline_speaks_of_the_thesis_where_it_has_a_number(value):
    row = {"case": "mine", "method": "split", "nmte_percent": 1.0, "outcome": Tally(["ok"])}
    row |= {"thesis_percent": value, "thesis_outcome": ""}
    columns = tuple(map(published, row, row))
    text = headline.text({"decay": table("decay", columns, [row], printed)}, {})
    assert "1.00" in text and ("thesis" in text) == np.isfinite(value)


def test_the_headline_says_nothing_of_what_was_not_asked():
    """Nor where some methods do not go with the scene whatever is asked."""
    rows = [{"case": "mine", "method": name} for name in ("ssmlearn", "modal_projection")]
    words = {"ssmlearn": "not run", "modal_projection": "skipped"}
    assert not headline.asked(headline.grid(rows, lambda row: words[row["method"]]))
    assert headline.asked(headline.grid(rows, lambda row: "skipped"))
    assert headline.checks([]) == []
    left = {"met": "not compared", "case": "folding", "method": "full_order", "source": "why"}
    assert headline.checks([left]) == ["Checks    folding, Full order: not compared, why"]


def test_one_case_is_not_the_hardest_of_many(collection, scores):
    found = answer.of(collection, scores)
    assert ", the hardest, " in sentences.hardest(found)
    alone = replace(found, cases=[found.hardest])
    assert sentences.hardest(alone).startswith(f"in case {found.hardest} the least errors")


def test_a_section_without_anything_to_say_is_left_out():
    every = [one["id"] for one in page_of.sections([], [], ())]
    assert [one["id"] for one in page_of.sections([], [], ("differences",))] == [
        name for name in every if name != "differences"
    ]


def test_captions_of_figures_speak_of_any_scene():
    """Where a probe is, the scene says."""
    plugs = {
        one.plug for name in outputs.families() for one in outputs.figures(name, ["mine"]).values()
    }
    said = {plug: " ".join(outputs.caption("figures", plug).paragraphs) for plug in plugs}
    assert len(said) > 20
    assert [plug for plug, text in said.items() if "0.525" in text or "bottom edge" in text] == []


def test_captions_name_the_thesis_where_a_scene_is_one_of_its_cases():
    names = {kind: plugs.names(f"report/{kind}") for kind in outputs.FORMATS}
    every = outputs.captions(names, ["mine", "folding"])
    assert every == outputs.captions(names)
    assert every["tables/decay"].title == "Table 3.4: error of the predicted decay"
    own = outputs.captions(names, ["mine"])
    assert own.keys() == every.keys()
    assert own["tables/decay"].title == "Error of the predicted decay"
    for name, caption in own.items():
        assert caption.paragraphs and not re.search("(?i)thesis|[23][.][0-9]", caption.rst), name
        if "thesis" not in every[name].rst.lower():
            assert caption.paragraphs == every[name].paragraphs, name


def test_a_figure_of_an_experiment_is_there_where_a_scene_asks_it():
    asked = {"mine": ["resonance"], "other": []}
    found = [outputs.figures("models", [scene], asked=asked.get) for scene in asked]
    assert ["resonance" in one for one in found] == [True, False]
