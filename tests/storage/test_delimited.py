"""Tables of other programs: the same numbers, however they are written, or a refusal."""

import numpy as np
import pytest

from pgimp.errors import CaseError
from pgimp.geometry.points.file import blocks
from pgimp.schema.profile import read_profile

X = np.round(np.random.default_rng(1).uniform(0.1, 12.0, (7, 3)), 5)


def table(separator=",", decimal=".", quotes="", numbers="", last=""):
    """A table of `X` as text."""
    names = separator.join(f"{quotes}{name}{quotes}" for name in ("x", "y", "volume"))
    lines = [
        separator.join(f"{numbers}{value:.5f}{numbers}".replace(".", decimal) for value in row)
        for row in X
    ]
    return "# a comment; with, all\tof them\n" + "".join(f"{each}{last}\n" for each in
                                                         (names, *lines))  # fmt: skip


FORMS = {
    "plain": table(),
    "semicolons": table(";"),
    "decimal commas": table(";", ","),
    "tabs": table("\t"),
    "tabs and decimal commas": table("\t", ",").replace("\n", "\r\n"),
    "spaces": table("  "),
    "quotes": table(quotes='"'),
    "all in quotes": table(quotes='"', numbers='"'),
    "decimal commas in quotes": table(",", ",", numbers='"'),
    "separators at ends": table(";", ",", last=";"),
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("form", FORMS)
def test_the_same_numbers_in_every_form(tmp_path, form, encoding, monkeypatch):
    path = tmp_path / "table.csv"
    path.write_text(FORMS[form], encoding=encoding, newline="")
    monkeypatch.setattr("pgimp.geometry.points.csv._TEXT", 90)  # a line or two at a time
    found = list(blocks(str(path), 2))
    assert len(found) > 2
    for values, expected in (
        (np.concatenate([block.position for block in found]), X[:, :2]),
        (np.concatenate([block.volume for block in found]), X[:, 2]),
    ):
        assert (values == expected).all()
    assert [block.place(0) for block in found[:1]] == ["line 3"]
    order = np.argsort(X[:, 0])
    head, names, *lines = FORMS[form].splitlines()
    path.write_text("\n".join([head, names, *(lines[i] for i in order)]), encoding=encoding)
    assert read_profile(str(path), "x", "volume") == tuple(
        (x, volume) for x, _, volume in X[order].tolist()
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (table(",", ","), "line 3: 6 values, expected 3; decimal commas cannot be told from"),
        ("x;y;volume\n1.5;2;1\n0,5;2;1\n", "'0,5' has a decimal comma, but numbers before it a"),
        ("x;y;volume\n1,5;2;1\n2.5;2;1\n", "'2.5' has a decimal point, but numbers before it a"),
        ("x;y;volume\n1.234,5;2;1\n", "has separators of thousands"),
        ("x\ty\tvolume\n1,234,567\t2\t1\n", "has separators of thousands"),
        ("x;y;volume\n1,234;2,500;1\n", "'1,234' may be 1.234 or 1234"),
        ("x;y;volume\n1_0;2;1\n", "'1_0' is no number"),
        ("x;y;volume\n1;2\n", "2 values, expected 3"),
        (table().encode("utf-16-le"), "it has zero bytes: it is no text, or UTF-16 without"),
    ],
)
def test_what_can_be_read_in_two_ways_is_named(tmp_path, text, words):
    path = tmp_path / "table.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    for read in (
        lambda: list(blocks(str(path), 2)),
        lambda: read_profile(str(path), "x", "volume"),
    ):
        with pytest.raises(CaseError) as caught:
            read()
        assert words in str(caught.value) and str(path) in str(caught.value)


def test_a_column_of_a_series_that_stands_twice_is_refused(tmp_path):
    path = tmp_path / "quake.csv"
    path.write_text("time,ax,ax,note,note\n0,1,2,0,0\n1,1,2,0,0\n")
    with pytest.raises(CaseError, match="line 1: there is more than one column 'ax'"):
        read_profile(str(path), "time", "ax")
    path.write_text("time,ax,note,note\n0,1,0,0\n1,1,0,0\n")
    assert read_profile(str(path), "time", "ax") == ((0.0, 1.0), (1.0, 1.0))
