"""Whatever stands in a file, the answer is settings or one line; never a traceback."""

import os
import random
from collections import Counter

import pytest
import yaml
from project_copy import ROOT

from vibrom.config import settings
from vibrom.config.errors import SettingsError

CASES = int(os.environ.get("VIBROM_FUZZ", "200"))
FILES = [
    "config/config.yaml",
    "config/scenes/folding.yaml",
    "config/scenes/small.yaml",
    "config/methods/split.yaml",
    "config/methods/split_plus.yaml",
    "config/methods/pysindy_modal.yaml",
    "config/methods/ssmlearn_11.yaml",
]
WORDS = [
    *("null", "{}", "[]", "''", "on", "0200", "1:30", "2e2", "3.0", ".nan", "-.inf", "1e-320"),
    *("1e400", "9" * 400, "9" * 5000, "-1", "0", "true", "[1, x]", "{a: 1}", "{null: 1}", "'\\0'"),
    *("!!python/name:os x", "&a [*a]", "*a", "? [1]", "2024-02-30", "é", "\u2028", "<<: {a: 1}"),
    *(
        "[[[[1]]]]",
        "split",
        "folding",
        "- - -",
        "|",
        '"\\x1b"',
        "\t",
        "\r",
        "#",
        "---",
        "%YAML 1.1",
    ),
]


def other_text(text: str, chance: random.Random) -> bytes:
    """One to three places of a file's text are something else."""
    for _ in range(chance.randint(1, 3)):
        at = chance.randrange(len(text))
        end = min(len(text), at + chance.choice([0, 1, 1, 3, 20, 200]))
        text = (
            text[:at] + chance.choice([*WORDS, text[at:end] * 2, "", "\n", " ", ":"]) + text[end:]
        )
    raw = text.encode("utf-8", "surrogatepass")
    return raw if chance.random() < 0.95 else raw[: chance.randrange(len(raw))] + b"\xff\x00"


def other_entry(text: str, chance: random.Random) -> bytes:
    """One entry of a file is something else, is gone, has another name or stands elsewhere."""
    content = yaml.safe_load(text)
    places = [(content, key) for key in content]
    for block, key in places:
        inner = block[key]
        items = (
            inner
            if isinstance(inner, dict)
            else range(len(inner))
            if isinstance(inner, list)
            else ()
        )
        places += [(inner, item) for item in items]
    (block, key), (source, name) = chance.choice(places), chance.choice(places)
    match chance.randrange(4):
        case 0:
            block[key] = "WORD"
        case 1:
            del block[key]
        case 2 if isinstance(block, dict):
            block[chance.choice(["WORD", str(key) + "s", str(name)])] = block.pop(key)
        case _:
            block[key] = source.get(name) if isinstance(source, dict) else name
    return yaml.safe_dump(content, sort_keys=False).replace("WORD", chance.choice(WORDS)).encode()


@pytest.mark.parametrize("mutate", [other_text, other_entry])
def test_any_file_is_settings_or_one_line(project, mutate):
    texts = {file: (ROOT / file).read_text() for file in FILES}
    chance, seen = random.Random(0), Counter()
    for _ in range(CASES):
        file = chance.choice(FILES)
        raw = mutate(texts[file], chance)
        (project / file).write_bytes(raw)
        overlay = project / "overlay.yaml"
        overlay.write_bytes(raw if chance.random() < 0.2 else b"seeds: [0]")
        try:
            settings.load(project / "config", [overlay])
            seen["fine"] += 1
        except SettingsError as error:
            assert str(error).isprintable() and len(str(error)) < 500, raw
            seen["refused"] += 1
        (project / file).write_text(texts[file])
    assert seen["fine"] > CASES / 30 and seen["refused"] > CASES / 3
