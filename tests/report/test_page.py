"""The report page and the headline: everything in one file, nothing fetched, no failure left out."""

from html.parser import HTMLParser
from pathlib import Path

import pandas as pd
import pytest

from vibrom.report import captions, names
from vibrom.report import headline as numbers
from vibrom.steps import figures, headline, report, tables

ROOT = Path(__file__).parents[2]
CAPTIONS = ROOT / "workflow" / "report"
SCENES = ["small", "large"]


class Reader(HTMLParser):
    """Tags that are opened, ids, image addresses, and whether what was opened was closed."""

    void = {"meta", "img", "br", "link", "hr"}

    def __init__(self, html):
        super().__init__()
        self.open, self.ids, self.images, self.links, self.text = [], [], [], [], []
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.ids += [attributes["id"]] if "id" in attributes else []
        self.images += [attributes["src"]] if tag == "img" else []
        self.links += [attributes["href"]] if "href" in attributes else []
        if tag not in self.void:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, f"</{tag}> closes nothing"

    def handle_data(self, data):
        self.text.append(data)


@pytest.fixture(scope="module")
def made(tree, tmp_path_factory):
    folder = tmp_path_factory.mktemp("out")
    numbers = [
        str(folder / "tables" / f"{name}.{form}")
        for name in names.tables("models", "cost", "effects")
        for form in names.TABLE_FORMATS
    ]
    pictures = [
        str(folder / "figures" / f"{name}.svg")
        for name in names.figures(SCENES, "models", "cost", "effects")
    ]
    common = {
        "scores": tree.scores,
        "provenance": {"source_digest": "feedbeef", "versions": '{"matplotlib": "3"}'},
    }
    tables.run(artefacts=tree.artefacts, tables=numbers, **common)
    figures.run(artefacts=tree.artefacts, figures=pictures[:2], **common)
    for path in pictures[2:]:  # what is in a picture is tested elsewhere
        Path(path).write_text("<svg/>")
    said = [str(CAPTIONS / name) for name in names.captions()]
    everything = dict(artefacts=tree.artefacts, tables=numbers, figures=pictures, captions=said)
    for name in ("report.html", "again.html"):
        report.run(report=str(folder / name), **everything, **common)
    headline.run(
        report=str(folder / "report.html"),
        tables=numbers,
        headline=str(folder / "headline.txt"),
        **common,
    )
    return folder


@pytest.fixture(scope="module")
def page(made):
    return (made / "report.html").read_text(encoding="utf-8")


def test_the_page_needs_nothing_else(page):
    reader = Reader(page)
    assert reader.open == []
    assert (
        "http" not in page and "url(" not in page and "<script" not in page and "<link" not in page
    )
    assert reader.images and all(source.startswith("data:image/") for source in reader.images)
    assert all(link.startswith("#") and link[1:] in reader.ids for link in reader.links)


def test_the_page_has_every_table_and_figure_once(page):
    ids = Reader(page).ids
    assert len(ids) == len(set(ids))
    assert {f"table-{name}" for name in names.tables("models", "cost", "effects")} | {
        f"figure-{name}" for name in names.figures(SCENES, "models", "effects")
    } <= set(ids)
    assert len(Reader(page).images) == len(names.figures(SCENES, "models", "cost", "effects"))


def test_the_page_shows_the_hard_cases_and_what_made_it(page):
    hard = page[page.index('id="hard"') :]
    assert "diverged: 3 of 9 points" in hard and "Modal projection" in hard and "0.0471" in hard
    assert (
        "feedbeef" in page
        and "0123456789abcdef" in page
        and "matplotlib 3" in page
        and "numpy 2.0" in page
    )
    assert "Schouten" in page and "Delft" in page


def test_the_page_is_the_same_twice(made):
    assert (made / "report.html").read_bytes() == (made / "again.html").read_bytes()


def test_the_headline_gives_ours_beside_the_thesis_and_where_to_look(made, capsys):
    text = (made / "headline.txt").read_text()
    assert max(len(line) for line in text.splitlines() if "/" not in line) <= 100
    row = next(line for line in text.splitlines() if line.startswith("SPLIT "))
    assert "3.00 (0.374)" in row and "3.00 (5.22)" in row
    assert "diverged (17.3)" in text and "1000 x" not in row
    assert "Checks    16 of 16 met" in text and "1 of 3 diverged" in text
    assert str(made / "report.html") in text and "make ui" in text


def test_the_headline_marks_failed_seeds_and_leaving_the_range(tmp_path):
    outcomes = [
        "left_range 2, diverged 1",
        "left_range",
        "ok 2, diverged 1",
        "ok 2, left_range 1",
        "ok",
    ]
    frame = pd.DataFrame(
        {
            "case": ["small", "large", "folding", "a", "b"],
            "method": "split",
            "nmte_percent": 1.56,
            "thesis_percent": 70.6,
            "thesis_outcome": None,
            "outcome": outcomes,
        }
    )
    assert list(numbers.errors(frame).iloc[0])[1:] == [
        "1.56* (70.6) 1 of 3 diverged",
        "1.56* (70.6)",
        "1.56 (70.6) 1 of 3 diverged",
        "1.56 (70.6) 1 of 3*",
        "1.56 (70.6)",
    ]
    worst = frame.assign(outcome="left_range 1, training_diverged 1, step_underflow 1")
    text = numbers.text({"decay": frame, "forced": worst}, {})
    assert text.count("* outside the range of its training data") == 1
    assert max(len(line) for line in text.splitlines()) <= 100
    assert "outside" not in numbers.text({"decay": frame.iloc[4:]}, {})


def test_every_table_and_figure_has_a_caption_for_both_reports():
    for name in names.captions():
        caption = captions.parse((CAPTIONS / name).read_text(encoding="utf-8"), name)
        assert caption.title and caption.paragraphs, name
        assert "{{" not in "".join(caption.paragraphs)


def test_a_file_without_a_caption_is_named():
    with pytest.raises(ValueError, match="mine.rst"):
        captions.parse("no title here", "mine.rst")


def test_only_failures_are_hard_cases(collection, scores):
    from vibrom.report import hard_cases
    from vibrom.report.scores import Scores

    good = Scores(scores.frame.assign(outcome="ok"))
    assert (
        list(hard_cases.table(collection, good)["Asked for"]) == ["without stop"] * 2
    )  # not elasticity, which cannot be left out
    hard = hard_cases.table(collection, scores).set_index("Model").drop("Full order")
    assert list(hard.index) == ["Modal projection", "SPLIT", "SPLIT+"]
    assert list(hard["Outcome"]) == ["diverged", "diverged", "training_diverged"]
    assert hard.loc["SPLIT", "Seeds"] == "1" and hard.loc["SPLIT", "Asked for"] == "forced"
    assert hard.loc["SPLIT+", "Asked for"].startswith("reconstruction, decay, backbone, forced")
