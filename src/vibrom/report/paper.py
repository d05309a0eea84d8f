"""`python -m vibrom.report.paper PAGE PDF`: the report as paper, printed by a browser without a
window, and how many pages it has.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
# The time that the page thinks it has to draw its plots; a browser skips what it would only wait.
PATIENCE = 120_000  # ms
LONGEST = 300  # s that a browser may take


class PaperError(Exception):
    """Nothing can be printed; the message says what to do."""


def browser() -> str | None:
    """The first of the browsers that is here."""
    return next(filter(None, map(shutil.which, NAMES)), None)


def opened(page: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """What a browser says that opens this page and does this."""
    found = browser()
    if found is None:
        raise PaperError(f"no browser: none of {', '.join(NAMES)}; install one, as apt chromium")
    with tempfile.TemporaryDirectory() as profile:
        command = [found, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run"]
        command += [f"--user-data-dir={profile}", f"--virtual-time-budget={PATIENCE}"]
        command += [*options, page.absolute().as_uri()]
        return subprocess.run(command, capture_output=True, text=True, timeout=LONGEST)


def printed(page: Path, pdf: Path) -> int:
    """How many pages it has on paper."""
    if not page.is_file():
        raise PaperError(f"{page}: no such page; run the main job first (make)")
    pdf.unlink(missing_ok=True)
    said = opened(page, "--no-pdf-header-footer", f"--print-to-pdf={pdf.absolute()}")
    if not pdf.is_file():
        last = [*said.stderr.strip().splitlines(), "it said nothing"][-1]
        raise PaperError(f"{page}: the browser printed nothing ({last})")
    return len(re.findall(rb"/Type\s*/Page\b", pdf.read_bytes()))


def main(page: str = "results/report.html", pdf: str = "results/report.pdf") -> None:
    """Print it and say how long it is."""
    try:
        print(f"{printed(Path(page), Path(pdf))} pages: {pdf}")
    except (PaperError, subprocess.TimeoutExpired) as error:
        sys.exit(f"vibrom: {error}")


if __name__ == "__main__":
    main(*sys.argv[1:3])
