"""Progress of long steps: how far, how fast, how long still. On a terminal a bar, where rich is
installed; else a line now and then.
"""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec

LINE_EVERY = 10.0  # s between two lines of a log


@contextmanager
def bar(title: str, total: int, unit: str) -> Iterator[Callable[[int], None]]:
    """Gives `advance(count)`."""
    if sys.stderr.isatty() and find_spec("rich"):
        with _drawn(title, total, unit) as advance:
            yield advance
        return
    state = {"done": 0, "spoken": time.monotonic()}
    started = time.monotonic()

    def speak(count: int) -> None:
        state["done"] += count
        now = time.monotonic()
        if now - state["spoken"] >= LINE_EVERY:
            state["spoken"] = now
            rate = state["done"] / (now - started)
            left = (total - state["done"]) / rate
            print(
                f"{title}: {100 * state['done'] / total:3.0f} %, {_short(rate)} {unit}/s, "
                f"{left:,.0f} s left",
                file=sys.stderr,
                flush=True,
            )

    yield speak


@contextmanager
def _drawn(title: str, total: int, unit: str) -> Iterator[Callable[[int], None]]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %  {task.fields[rate]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task, started = progress.add_task(title, total=total, rate=""), time.monotonic()

        def advance(count: int) -> None:
            done = progress.tasks[0].completed + count
            rate = done / max(time.monotonic() - started, 1e-9)
            progress.update(task, advance=count, rate=f"{_short(rate)} {unit}/s")

        yield advance


def _short(rate: float) -> str:
    """Two digits of a slow one."""
    return f"{rate:,.0f}" if rate >= 9.5 else f"{rate:.2g}"
