"""Files of the configuration as text: YAML 1.2, and what of it is refused in one line."""

import pytest
from reading import complaint, overlay

from vibrom.config import files

HUNDRED = ",".join("1" * 100)


@pytest.mark.parametrize(
    "text, says",
    [
        ("a: 1\na: 2\n", "line 2 'a' is given twice; remove one"),
        ("a: [1\n", "is not YAML"),
        ("- 1\n", "holds no"),
        ("", "holds no"),
        ("a: &a [*a]", "alias *a holds itself"),
        ("a: *b", "alias *b stands for nothing before it"),
        (
            f"a: &a [{HUNDRED}]\nb: &b [{HUNDRED.replace('1', '*a')}]\n"
            f"c: [{HUNDRED.replace('1', '*b')}]",
            "line 3 grows beyond 100000 entries",
        ),
        ("a: " + "[" * 100_000, "nested more than"),
        ("{[1, 2]: 3}", "has a key that is no word"),
        ("a: !!python/name:os.system x", "has the tag"),
        ("a: 1\n---\nb: 2\n", "begins a second document"),
        ("a: \x01", "is not YAML"),
        ("a: 1\n<<: 3\n", "merges blocks only"),
        ("a: caf\u00e9".encode("latin-1"), "is not UTF-8 text; save it as UTF-8"),
        ("a: 1".encode("utf-16"), "is not UTF-8 text"),
    ],
)
def test_text_that_is_no_configuration(project, tmp_path, text, says):
    line = complaint(project, overlay(tmp_path, text))
    assert "mine.yaml: " in line and says in line


def test_a_file_that_is_not_there(project, tmp_path):
    assert "gone.yaml: file cannot be read (No such" in complaint(project, tmp_path / "gone.yaml")


@pytest.mark.parametrize(
    "word, value",
    [
        ("1e-8", 1e-8),
        ("104.0e9", 104e9),
        ("2e2", 200.0),
        ("-3", -3),
        ("true", True),
        ("~", None),
        *((text, text) for text in ("on", "no", "0200", "0o17", "0x1f", "1:30", "1_000")),
        *((text, text) for text in ("2024-02-30", "NA", "inf", "True story")),
    ],
)
def test_plain_words_are_those_of_yaml_1_2(tmp_path, word, value):
    found = files.read(overlay(tmp_path, f"a: {word}\n{word}: 1\nb: '{word}'\n"))
    assert found == {"a": value, word: 1, "b": word} and type(found["a"]) is type(value)


def test_aliases_and_merges_write_blocks_again(tmp_path):
    text = "a: &a {x: 1, y: 2}\nb: &b {x: 3}\nc: {<<: [*b, *a], z: *b}\nd: {<<: *a, x: 0}\n"
    found = files.read(overlay(tmp_path, text))
    assert found["c"] == {"x": 3, "y": 2, "z": {"x": 3}} and found["d"] == {"x": 0, "y": 2}
