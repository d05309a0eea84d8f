"""Tables of text as devices and programs write them: all hold the same two columns."""

import numpy as np
import pytest

from vibrom.recordings.text import table

TIME = np.arange(30) / 8.0
X = np.round(np.cos(TIME), 6)


def rows(separator=",", point="."):
    return "\n".join(f"{t:.6f}{separator}{x:.6f}".replace(".", point) for t, x in zip(TIME, X))


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (rows(), ["column_1", "column_2"]),
        ("t,x\n" + rows(), ["t", "x"]),
        ('"Time (ms)","tip [mm]"\r\n' + rows().replace("\n", "\r\n"), ["Time (ms)", "tip [mm]"]),
        ("t\tx\n" + rows("\t"), ["t", "x"]),
        ("Zeit;Weg\n" + rows(";", ","), ["Zeit", "Weg"]),
        ("Zeit\tWeg\n" + rows("\t", ","), ["Zeit", "Weg"]),
        ("# t x\n" + rows("   "), ["t", "x"]),
        ("% made by hand\n\n" + rows(" "), ["column_1", "column_2"]),
        ("Scope 3\nDate: 2024-01-01\nRate: 8\n\nt,x\n" + rows(), ["t", "x"]),
        (
            "Date,2024-01-01\nTime,Channel A\n(ms),(mm)\n\n" + rows(),
            ["Time (ms)", "Channel A (mm)"],
        ),
        ("t,x\ns,mm\n" + rows(), ["t (s)", "x (mm)"]),
        ("x,x\n" + rows(), ["x", "x_2"]),
        ("t,x\n" + rows().replace("\n", ",\n") + ",", ["t", "x"]),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_two_columns_are_found_with_their_names(tmp_path, text, names, encoding):
    path = tmp_path / "it.txt"
    path.write_text(text, encoding=encoding)
    found = table(path)
    assert list(found) == names
    for values, expected in zip(found.values(), (TIME, X)):
        np.testing.assert_allclose(values, expected, atol=1e-12)


def test_what_is_no_number_is_missing(tmp_path):
    lines = ("t,x\n" + rows()).splitlines()
    lines[5] = lines[5].partition(",")[0] + ",overflow"
    (tmp_path / "it.csv").write_text("\n".join(lines))
    found = table(tmp_path / "it.csv")
    assert np.isnan(found["x"][4]) and np.isfinite(np.delete(found["x"], 4)).all()
    np.testing.assert_array_equal(found["t"], TIME)
