"""Prose of the pages: lines end at 100 characters, and sentences at 25 words."""

import re
from pathlib import Path

import pytest
from pages import DOCS, FENCE, ROOT

TEXTS = ROOT / "scripts" / "pages" / "texts"
MOST_CHARACTERS = 100
MOST_WORDS = 25
#: Pages whose sentences are still to be mended.
LATER = {"case-file.md", "limits.md", "soils-and-fluids.md"}
#: A line of its own kind: table, heading, picture, comment, formula, place of a table.
WHOLE = ("|", "#", "![", "<!--", "    ", "{{", "Measured on ")
ITEM = re.compile(r"\s*(- |\d+\. )")
#: The end of a sentence; not of an initial (S. G. Bardenhagen), of "et al.", nor of "...".
END = re.compile(r"(?<=[.!?])(?<!\b[A-Z]\.)(?<! al\.)(?<!\.\.)[)\"]*\s+")


def sources():
    """Files in which prose is written: for pages with tables of figures, their texts."""
    written = {path.name: path for path in DOCS.glob("*.md")}
    written |= {path.name: path for path in TEXTS.glob("*.md")}
    tutorials = sorted((DOCS / "tutorials").glob("*.md"))
    return [ROOT / "README.md", *(written[name] for name in sorted(written)), *tutorials]


def rooms():
    """What the folders of the package say of themselves."""
    return sorted((ROOT / "pgimp").rglob("README.md"))


def paragraphs(text):
    """Paragraphs and items of lists, each in one line; what stands in a line whole is left out."""
    lines: list[str] = []
    for line in FENCE.sub("", text).splitlines():
        if not line.strip() or (line.startswith(WHOLE) and not (line[0] == " " and lines)):
            yield " ".join(lines)
            lines = []
            continue
        if item := ITEM.match(line):
            yield " ".join(lines)
            lines = []
            line = line[item.end() :]
        lines.append(line.strip())
    yield " ".join(lines)


def sentences(text):
    """Sentences of the prose; a piece of code is one word, a link is its words."""
    for paragraph in paragraphs(text):
        plain = re.sub(r"`[^`]*`", "code", paragraph)
        plain = re.sub(r"\[([^\]]*)\]\([^)\s]*\)", r"\1", plain).replace("*", "")
        yield from END.split(plain)


def words(sentence):
    """The words of a sentence: signs alone are none."""
    return [word for word in sentence.split() if re.search(r"\w", word)]


def too_long(text):
    """Prose lines with too many characters that could be broken."""
    for line in FENCE.sub("", text).splitlines():
        breakable = len(ITEM.sub("", line, count=1).split()) > 1
        if len(line) > MOST_CHARACTERS and breakable and not line.startswith(WHOLE):
            yield line


def test_sentences_are_found():
    text = (
        "# A title. With two\n\nOne. Two `a. b` is [a link](to.md#it). S. G. Who et al. "
        "wrote\nthree ...\n\n- item (one). (Two!) Three\n- 4.5 is\n  one\n\n"
        "| a table. |\n\n```sh\ncode. code\n```\n"
    )
    assert [each for each in sentences(text) if each] == [
        "One.", "Two code is a link.", "S. G. Who et al. wrote three ...",
        "item (one).", "(Two!", "Three", "4.5 is one",
    ]  # fmt: skip
    assert len(words("w = 1 - (a + b), or so")) == 6


def test_long_lines_are_found():
    long = "word " * 25
    text = f"{long}\n| {long} |\n- {long}\n- [a](x{'x' * 100})\n```sh\n{long}\n```\nshort\n"
    assert list(too_long(text)) == [long, f"- {long}"]


@pytest.mark.parametrize(
    "path", sources() + rooms(), ids=lambda path: f"{path.parent.name}/{path.name}"
)
def test_lines_end_at_100_characters(path: Path):
    assert list(too_long(path.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize(
    "path", [path for path in sources() if path.name not in LATER], ids=lambda path: path.name
)
def test_sentences_have_at_most_25_words(path: Path):
    found = sentences(path.read_text(encoding="utf-8"))
    assert [each for each in found if len(words(each)) > MOST_WORDS] == []
