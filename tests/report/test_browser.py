"""The page in a browser: nothing is fetched, nothing complains, every control does what it says."""

import html
import json
import re
from pathlib import Path

import pytest

from vibrom.report import paper

pytestmark = pytest.mark.skipif(
    paper.browser() is None, reason=f"no browser to open the page in: none of {paper.NAMES}"
)
TRIES = 3
# Put before and behind the page's own scripts; what was seen stands in the page at the end.
LISTEN = f"<script>{(Path(__file__).parent / 'listen.js').read_text()}</script>"
ACT = f"<script>{(Path(__file__).parent / 'act.js').read_text()}</script>"
PAPER = 718  # [px] a page of A4 without its margins
# The small run has half the scenes and a quarter of the methods of a whole one, which may have 25.
PAGES = 8


def opened(page: str, folder, width: int) -> dict:
    """What the browser saw."""
    copy = folder / "page.html"
    text = page.replace("<head>", "<head>" + LISTEN, 1).replace("</body>", ACT + "</body>")
    copy.write_text(text, encoding="utf-8")
    # On a busy machine the browser's own time may run out before all plots are drawn.
    for _ in range(TRIES):
        answer = paper.opened(copy, f"--window-size={width},900", "--dump-dom")
        found = re.search('<pre id="seen">(.*?)</pre>', answer.stdout, re.DOTALL)
        assert found, answer.stderr[-2000:]
        seen = json.loads(html.unescape(found[1]))
        if seen.get("panels") == seen.get("drawn"):
            break
    return seen


@pytest.fixture(scope="module")
def seen(page, tmp_path_factory):
    """On a wide screen."""
    return opened(page, tmp_path_factory.mktemp("browser"), 1400)


def test_nothing_complains_and_nothing_is_fetched(seen):
    assert seen["complaints"] == [] and seen["fetched"] == []


def test_every_plot_is_drawn_and_tells_who_it_is(seen):
    assert seen["panels"] == seen["drawn"] > 15
    assert re.match(r"<b>SPLIT\+, seed \d", seen["hover"]) and "[" not in seen["hover"]
    assert "time since release" in seen["hover"] and "%{y" in seen["hover"]
    assert seen["csv"] > 100


def test_a_click_shows_a_method_alone_everywhere_and_another_shows_all(seen):
    assert len(seen["before"]) > 3 and seen["before"] == seen["again"]
    assert seen["alone"] == ["full_order", "split"]
    assert seen["pressed"] == "true" and seen["beam"] == "split"


def test_a_click_changes_between_log_and_linear(seen):
    assert seen["scales"] == ["log", "linear"]


def test_tables_sort_and_filter(seen):
    def numbers(cells):
        return [float(cell.split()[0]) for cell in cells if cell[:1].isdigit()]

    assert (
        numbers(seen["rising"]) == sorted(numbers(seen["rising"])) and seen["sort"] == "descending"
    )
    assert numbers(seen["falling"]) == sorted(numbers(seen["falling"]), reverse=True)
    assert len(seen["left"]) == 2 and all("smallSPLIT" in row for row in seen["left"])


def test_the_beam_moves_with_the_slider(seen):
    assert seen["times"][0] != seen["times"][1] and seen["times"][1].endswith(" s")
    assert "full order: free end at x" in seen["said"] and seen["ink"] > 500


@pytest.mark.parametrize("width", [500, 1400])  # no window of this browser is narrower
def test_the_page_is_no_wider_than_the_window(page, seen, width, tmp_path):
    found = seen if width == 1400 else opened(page, tmp_path, width)
    assert found["wide"] <= 0


def test_paper_has_few_pages_and_no_table_is_cut(page, tmp_path):
    on_paper = page.replace("@media print", "@media all")
    wide = opened(on_paper, tmp_path, PAPER)["wide"]
    assert on_paper != page and wide <= 0
    (tmp_path / "page.html").write_text(page, encoding="utf-8")
    count = paper.printed(tmp_path / "page.html", tmp_path / "page.pdf")
    assert 3 < count <= PAGES
