"""The example of a method in docs/, taken from its text and put beside those of the package."""

import re
from pathlib import Path

import pytest

import vibrom.methods

WALK = (Path(__file__).parents[2] / "docs/walks/method.md").read_text()
NAME, CODE = re.search(
    r"`src/vibrom/methods/(\w+)\.py`.*?^```python\n(.*?)^```", WALK, re.DOTALL | re.MULTILINE
).groups()


@pytest.fixture(scope="session")
def example(tmp_path_factory):
    """The name of that method, which `method_from_settings` now finds."""
    folder = tmp_path_factory.mktemp("methods")
    (folder / f"{NAME}.py").write_text(CODE)
    vibrom.methods.__path__.append(str(folder))
    yield NAME
    vibrom.methods.__path__.remove(str(folder))
