"""The report page and the headline: all in one file, nothing fetched, no failure left out."""

import base64
import gzip
import io
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
from markupsafe import escape
from matplotlib.figure import Figure
from PIL import Image
from written import EXPERIMENTS, PLUGS, TABLES

from vibrom.artefacts.outcome import Tally
from vibrom.models.measures import nmte_percent
from vibrom.report import answer, failures, outputs, sentences, tables
from vibrom.report import headline as numbers
from vibrom.report import page as page_of
from vibrom.report.columns import number
from vibrom.report.page import HEAVY, image
from vibrom.report.scores import Scores
from vibrom.report.table import Printed, Table
from vibrom.thesis.labels import label


class Reader(HTMLParser):
    """Tags that are opened, ids, image addresses, and whether what was opened was closed."""

    void = {"meta", "img", "br", "link", "hr", "input", "wbr"}

    def __init__(self, html):
        super().__init__()
        self.open, self.ids, self.images, self.links = [], [], [], []
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


def test_the_page_needs_nothing_else(page):
    reader = Reader(page)
    assert reader.open == [] and len(page) < 8_000_000
    code = gzip.decompress(base64.b64decode(re.search('id="plotly-code">([^<]*)<', page)[1]))
    assert code.startswith(b"/**\n* plotly.js v")
    assert not any(text in page for text in ("http:", "https:", "url(", "<link"))
    assert reader.images and all(source.startswith("data:image/") for source in reader.images)
    assert all(link[1:] in reader.ids for link in reader.links if link[0] == "#")


def test_every_figure_links_to_its_data(page, made, small):
    links = [link for link in Reader(page).links if link[0] != "#"]
    assert all(re.fullmatch(r"tables/\w+\.csv|figures/\w+\.pdf|.+\.nc", link) for link in links)
    every = [name for family in outputs.families() for name in outputs.tables(family, EXPERIMENTS)]
    known = {f"tables/{name}.csv" for name in every}
    assert {link for link in links if link.endswith(".csv")} <= known
    paths = [small.results / link for link in links if link.endswith(".nc")]
    assert paths and all(path.exists() for path in paths)
    blocks = re.findall(r"<figure id.*?</figure>", page, re.DOTALL)
    assert len(blocks) == len(PLUGS) and all('href="figures/' in block for block in blocks)


def test_the_page_has_every_table_and_figure_once(page):
    reader = Reader(page)
    ids = reader.ids
    assert len(ids) == len(set(ids))
    wanted = {f"table-{name}" for name in TABLES} | {f"figure-{name}" for name in PLUGS}
    assert wanted <= set(ids) and "table-backbone" in ids
    assert {f"#{name}" for name in wanted} <= set(reader.links)  # from the contents
    assert page.index('id="figure-accuracy_cost"') < page.index('id="models"')  # at a glance


def test_tables_are_read_to_the_blind(page):
    for table in re.findall(r"<table.*?</table>", page, re.DOTALL):
        assert "<caption>" in table or "data-name" not in table
        assert '<th scope="col">' in table or "data-name" not in table
    short = re.findall(r'<img [^>]*alt="([^"]*)"', page)
    panels = re.findall(r'class="panel" role="img"[^>]*aria-label="([^"]*)"', page)
    assert short and all(40 < len(words) < 300 for words in short)
    assert len(panels) > 10 and all(20 < len(words) < 300 for words in panels)


def test_every_figure_has_its_numbers_in_words_beside_it(page):
    words = dict(
        re.findall(r'<details class="words" id="words-(\w+)">(.*?)</details>', page, re.DOTALL)
    )
    assert set(words) == PLUGS and all("<p>" in said for said in words.values())
    assert set(re.findall(r'aria-details="words-(\w+)"', page)) == PLUGS
    assert "Full order: " in words["backbones"] and " to " in words["backbones"]


def test_the_answer_is_made_of_the_numbers(page, real):
    scored = Scores.of(real)
    found = answer.of(real, scored)
    medians = {
        method: scored.spread("large", method, "decay", "nmte_percent").median
        for method in real.methods
    }
    best = min(medians, key=medians.get)
    assert [m for m in real.methods if found.cells["large", m, "decay"].best] == [best]
    assert found.cells["large", best, "decay"].text == number(medians[best], 3)
    said, more = sentences.of(found), sentences.remarks(found, real)
    assert len(said) == 2 and all(escape(text) in page for text in (*said, *more))
    assert found.hardest in said[0] and "as fast as the full order" in said[1]
    assert said[1].startswith(f"{label(lowest(found))} is ready after ")
    assert more[-1].startswith("Within 5 % small needs")


def lowest(found):
    """The method with the least error of the decay in the hardest case."""
    cells = {method: found.cells[found.hardest, method, "decay"].value for method in found.methods}
    return min(cells, key=cells.get)


def test_the_page_shows_the_failures_and_what_made_it(page):
    found = page[page.index('id="failures"') :].replace("<wbr>", "")
    assert "training_diverged: 9 of 18 points" in found and "SPLIT+" in found
    assert "0123456789abcdef" in page and "numpy 2.0" in page
    assert "Schouten" in page and "Delft" in page


def test_a_heavy_drawing_goes_in_as_pixels_of_few_colours():
    figure = Figure(figsize=(4.0, 3.0))
    axes = figure.subplots()
    for slow in range(5, 25):
        axes.plot(np.sin(np.arange(50) / slow))
    made = io.BytesIO()
    figure.savefig(made, format="png")
    light, heavy = b"<svg/>", b"x" * (HEAVY + 1)
    assert image({"svg": light, "png": made.getvalue()}).startswith("data:image/svg+xml;base64,")
    kind, _, content = image({"svg": heavy, "png": made.getvalue()}).partition(",")
    shown = base64.b64decode(content)
    assert kind == "data:image/png;base64" and len(shown) < 0.6 * len(made.getvalue())
    opened = (Image.open(io.BytesIO(png)).convert("RGB") for png in (shown, made.getvalue()))
    few, all_ = (np.asarray(picture, float) for picture in opened)
    assert few.shape == all_.shape and np.abs(few - all_).mean() < 3.0  # of 255


def test_the_page_is_the_same_twice(made):
    assert (made / "report.html").read_bytes() == (made / "again.html").read_bytes()


def test_scores_csv_is_what_the_artefacts_say(made, real):
    lines = (made / "scores.csv").read_text().splitlines()
    assert lines[0] == "scene,method,seed,experiment,metric,value,unit,seconds,outcome,endings"
    assert len(lines) == 1 + len(Scores.of(real).rows)
    begun = {line.rsplit(",", 5)[0]: line for line in lines}
    assert "small,modal_projection,unseeded,decay,nmte_percent" in begun
    assert begun["small,split,1,frc,completed"].startswith("small,split,1,frc,completed,9.0,1,")


def test_the_store_has_a_run_for_each_model(made, small, real):
    import sqlite3

    with sqlite3.connect(made / "mlflow.db") as database:
        runs = {name for (name,) in database.execute("select name from runs")}
        tags = database.execute("select value from tags where key = 'artefacts'").fetchall()
        ended = database.execute("select value from tags where key = 'outcome.decay'").fetchall()
        (balances,) = database.execute(
            "select count(*) from metrics where key = 'balance/decay_percent'"
        ).fetchone()
        models = {
            value for (value,) in database.execute("select value from tags where key='model'")
        }
    assert {"small full_order", "small modal_projection", "large split"} <= models
    assert {"summary", "small full_order", "large split seed_1"} <= runs
    assert "small modal_projection unseeded" in runs and ("training_diverged",) in ended
    known = [row.value for row in Scores.of(real).rows if row[3:5] == ("balance", "decay_percent")]
    assert balances == np.isfinite(known).sum() > 3
    homes = {Path(path).resolve() for (path,) in tags}
    assert (small.results / "large/split/seed_1").resolve() in homes


def test_a_fitted_model_is_loaded_from_the_store_and_predicts_as_the_scores_say(made, real):
    """Bit for bit: the same model, settings and compiled code."""
    import mlflow

    client = mlflow.MlflowClient(f"sqlite:///{made / 'mlflow.db'}")
    for method, seed in (("modal_projection", None), ("split", 1)):
        whose = "unseeded" if seed is None else f"seed_{seed}"
        wanted = f"attributes.run_name = 'small {method} {whose}'"
        (run,) = client.search_runs(["1"], wanted)
        (output,) = run.outputs.model_outputs
        home = client.get_logged_model(output.model_id).artifact_location
        record = real.find("small", "full_order", "test")
        predicted = mlflow.pyfunc.load_model(home).predict(record.encoding["source"])
        error = nmte_percent(record["displacement"].values, predicted.values)
        assert error == Scores.of(real).value("small", method, seed, "decay", "nmte_percent")
        assert output.model_id in run.data.tags["mlflow.note.content"]


def test_the_headline_gives_ours_beside_the_thesis_and_where_to_look(made, real):
    text = (made / "headline.txt").read_text()
    assert max(len(line) for line in text.splitlines() if "/" not in line) <= numbers.WIDTH
    scored = Scores.of(real)
    row = next(line for line in text.splitlines() if line.startswith("SPLIT "))
    for case, thesis in (("small", "0.374"), ("large", "5.22")):
        median = scored.spread(case, "split", "decay", "nmte_percent").median
        assert f"{numbers.number(median, 3)} ({thesis})" in row
    assert "training diverged 1" in text or "1 of 2 training diverged" in text
    assert "Checks " in text and str(made / "report.html") in text and "make ui RESULTS=" in text


def test_the_headline_leaves_out_what_no_method_was_asked():
    rows = [{"case": "small", "method": "split"}]
    cell = numbers.grid(rows, lambda _: "not run (4.2)")
    assert not numbers.asked(cell)
    assert numbers.asked(numbers.grid(rows, lambda _: "diverged (4.2)"))
    assert not numbers.asked(numbers.grid([], str))


def table_of(outcomes, **changes):
    """A table of errors of one method, a case an outcome."""
    rows = [
        {
            "case": case,
            "method": "split",
            "nmte_percent": 1.56,
            "thesis_percent": 70.6,
            "thesis_outcome": "",
            "outcome": outcome,
            **changes,
        }
        for case, outcome in zip(("small", "large", "folding", "a", "b"), outcomes)
    ]
    return Table("decay", (), rows, None)


def test_the_headline_marks_failed_seeds_and_leaving_the_range():
    left, bad, ok = "left_range", "diverged", "ok"
    outcomes = [[left, left, bad], [left], [ok, ok, bad], [ok, ok, left], [ok]]
    made = table_of(map(Tally, outcomes))
    assert list(numbers.grid(made.rows, numbers.error).iloc[0])[1:] == [
        "1.56* (70.6) 1 of 3 diverged",
        "1.56* (70.6)",
        "1.56 (70.6) 1 of 3 diverged",
        "1.56 (70.6) 1 of 3*",
        "1.56 (70.6)",
    ]
    lost = table_of([Tally([bad, bad, ok])], nmte_percent=np.nan, thesis_outcome="fails")
    assert numbers.error(lost.rows[0]) == "diverged 2, ok 1 (fails)"
    worst = table_of([Tally([left, "training_diverged", "step_underflow"])] * 5)
    text = numbers.text({"decay": made, "forced": worst}, {})
    assert text.count("* outside the range of its training data") == 1
    assert max(len(line) for line in text.splitlines()) <= numbers.WIDTH
    assert "outside" not in numbers.text({"decay": table_of([Tally([ok])])}, {})


def test_only_failures_are_in_the_table_of_failures(collection, scores):
    lines = failures.build(collection, scores).printed.frame.set_index(["Case", "Model"])
    assert list(lines.loc[[("small", "Full order")], "Evaluated"]) == ["without stop"]
    modal = lines.loc[[("large", "Modal projection")]]
    assert dict(zip(modal["Evaluated"], modal["When [s]"]))["forced"] == "0.0110"
    assert "diverged: 3 of 9 points" in set(modal["Outcome"])
    split = lines.loc[[("large", "SPLIT")]]
    assert list(split[split["Outcome"] == "diverged"]["Seeds"]) == ["1"]
    unfit = lines.loc[[("large", "SPLIT+")]]
    whole = unfit[unfit["Outcome"] == "training_diverged"]["Evaluated"].iloc[0]
    assert {"reconstruction", "decay", "backbone", "forced"} <= set(whole.split(", "))


def test_a_run_without_failures_has_none(collection, real):
    good = [key for key in real.loaders if key.model == "modal_projection" and key.scene == "small"]
    part = type(real)({key: real.loaders[key] for key in good})
    assert not failures.build(part, Scores.of(part)).rows


def test_headline_checks_name_what_is_not_met(collection, scores):
    made = tables.make("checks", collection, scores)
    lines = numbers.checks([*made.rows, made.rows[0] | {"met": "no", "value": 2.0}])
    count = sum(row["met"] in ("yes", "no") for row in made.rows)
    assert lines[0].endswith(f"{count} of {count + 1} met")
    (missed,) = (line for line in lines if line.startswith("not met   small, "))
    assert "2.00000" in missed


def test_endings_are_told_with_the_gravest_first():
    assert answer.in_words(Tally(["ok", "ok"])) == ""
    assert answer.in_words(Tally(["left_range"] * 3)) == "left its training range"
    mixed = Tally(["ok"] + ["left_range"] * 3 + ["diverged"] * 2)
    assert answer.in_words(mixed) == "of 6: 2 diverged, 3 left range"


def test_a_table_stands_in_two_columns_of_paper_only_where_its_words_fit():
    def narrow(*cells):
        return page_of.narrow(Table("", (), (), Printed(["Case"] * len(cells), [cells], [""])))

    assert narrow("folding", "Equations (corrected)", "0.1471") and not narrow("word " * 30)
    assert narrow("training_diverged") and not narrow("x" * 80)
    assert narrow(*["1.000"] * 12) and not narrow(*["1.000"] * 13)
