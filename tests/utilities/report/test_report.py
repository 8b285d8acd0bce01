"""``pgimp report``: whole, self-contained pages of runs in every state, and of studies."""

import json
import re
import tomllib
from html.parser import HTMLParser
from unittest.mock import patch

import pytest
from pages import ROOT
from ruamel.yaml import YAML

import pgimp
from pgimp.errors import UsageError
from pgimp.storage import atomic
from pgimp.utilities.report import citation, drawings, parts
from pgimp.utilities.report.html import BEGINNING, Markup
from pgimp.utilities.report.markdown import to_html
from pgimp.utilities.report.run import report_of_run

pytestmark = pytest.mark.slow(30)

VOID = {"meta", "img", "br", "rect", "line", "link", "path", "use", "hr"}


class Checked(HTMLParser):
    """Tags that are closed in their order, ids that are there once, nothing from elsewhere."""

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.links, self.tags, self.words = [], [], [], set(), []
        self.feed(text)
        assert not self.open
        assert len(self.ids) == len(set(self.ids))
        assert "script" not in self.tags
        for link in self.links:
            assert link.startswith(("#", "data:image/png;base64,", "runs/")), link
            assert not link.startswith("#") or link[1:] in self.ids, link

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        for name, value in attrs:
            if name == "id":
                self.ids.append(value)
            elif name in ("href", "src", "xlink:href"):
                self.links.append(value)
            assert not name.startswith("on")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


def written(path):
    return Checked((path / "report.html").read_text()).text


def edit(path, **changes):
    content = json.loads((path / "run.json").read_text())
    content["starts"][-1].update(changes)
    (path / "run.json").write_text(json.dumps(content))


def test_a_page_of_a_run(copied, report):
    status, out, err = report(copied)
    assert (status, err) == (0, "") and out.startswith(f"wrote {copied / 'report.html'} (")
    text = written(copied)
    for words in (
        "Two soft blocks", "done", "72", "particle-steps/s (energy lost by the method:",
        "cells across 'left'", "Energies and works over time", "lost by the method",
        "not explained", "reaction.x-min-x", "P2G", "neo-hookean", "blocks.out", "numba",
        citation.software("0.1.0")[:40], "von Mises stress, t = 0, t =", "docs/hard-cases.md",
    ):  # fmt: skip
        assert words in text, words
    source = (copied / "report.html").read_text()
    assert source.count("data:image/png") == 1 and "http://www.w3.org" in source
    assert not re.search(r"(src|href)=\"http", source) and len(source) < 1 << 20
    assert not list(copied.glob(".*.part"))
    assert report(copied)[0] == 0, "an older report is replaced"


def test_states_of_a_run(copied, report):
    edit(copied, state="running", seconds=None, particle_steps=None, ended=None)
    report(copied)
    assert "running, or killed at t = 2, 100 %" in written(copied)
    (copied / "failure").mkdir()
    (copied / "failure" / "report.txt").write_text(
        "<gone>\n\nIt was & fast.\n\nThe last lines of h"
    )
    edit(copied, state="failed", message="particle 3 is <gone>", time=1.0)
    report(copied)
    text = written(copied)
    assert "failed at t = 1, 50 %" in text and "particle 3 is <gone>" in text
    assert "It was & fast." in text and "The last lines" not in text
    start = json.loads((copied / "run.json").read_text())
    start["starts"].append(start["starts"][0] | {"state": "done", "resumed_from": 100})
    (copied / "run.json").write_text(json.dumps(start))
    report(copied)
    assert "the start" in written(copied) and "from step" in written(copied)


def test_what_is_not_there_is_said(copied, report):
    for path in (copied / "frames").iterdir():
        path.unlink()
    report(copied)
    assert "There is no frame with particles." in written(copied)
    (copied / "history.csv").unlink()
    (copied / "log.txt").unlink()
    report(copied)
    assert "history.csv has no line." in written(copied)
    (copied / "history.csv").write_text("time,step\n0.0,0\n0.1,x\n")
    assert report(copied)[0] == 0
    assert "history.csv, line 3 is damaged" in written(copied)
    (copied / "case.yaml").write_text("dimensions: [")
    assert report(copied)[0] == 0
    assert "case.yaml" in written(copied)


def test_damaged_frames_are_said(copied, report):
    for path in (copied / "frames").iterdir():
        path.write_bytes(b"no HDF5")
    assert report(copied)[0] == 0
    assert "The frames cannot be read" in written(copied)


def test_fields_and_files(copied, report, tmp_path, monkeypatch):
    other = tmp_path / "other.html"
    assert report(copied, "-o", other, "--field", "velocity.x")[0] == 0
    assert "velocity x, t = 0" in Checked(other.read_text()).text
    other.write_text("<p>mine</p>")
    status, _, err = report(copied, "-o", other)
    assert status == 2 and "is no report of pgimp" in err and other.read_text() == "<p>mine</p>"
    for words, message in (
        ((copied, "-o", "page.pdf"), "must end in .html"),
        ((copied, "-o", tmp_path / "no" / "page.html"), "there is no folder"),
        ((copied, "--field", "odd"), "field"),
        ((tmp_path / "no.out",), "there is no run directory"),
        ((tmp_path,), "is no run directory of pgimp"),
    ):
        status, _, err = report(*words)
        assert status == 2 and message in err
    refuse = OSError(30, "Read-only file system")
    monkeypatch.setattr(atomic, "write", lambda *_: (_ for _ in ()).throw(refuse))
    status, _, err = report(copied)
    assert status == 2 and "name another file with -o" in err


def test_a_new_run_takes_the_report_of_the_old_one_away(copied, report):
    report(copied)
    case = pgimp.open(copied).case
    pgimp.run(case, output=copied, overwrite=True, overrides=["time.end=1.0"], quiet=True)
    assert not (copied / "report.html").exists()


def test_open_tells_where_there_is_no_browser(copied, report, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", lambda url: bool(opened.append(url)))
    status, out, _ = report(copied, "--open")
    assert status == 0 and "note: no browser" in out
    assert opened == [(copied / "report.html").resolve().as_uri()]


def test_a_page_of_a_study(copied, report, tmp_path):
    (tmp_path / "s.study.out" / "runs").mkdir(parents=True)
    folder = tmp_path / "s.study.out"
    copied.rename(folder / "runs" / "one")
    report(folder / "runs" / "one")
    (folder / "study.csv").write_text("run,state,error\none,done,0.0123\ntwo,failed,\n")
    (folder / "study.md").write_text(
        "# A study\n\n| a | b |\n|---|---|\n| x\\|y | `2` |\n\n- done\n"
    )
    status, _, err = report(folder)
    assert (status, err) == (0, "")
    text = written(folder)
    for words in ("A study", "1 of 2 runs are done", "x|y", "an error of 0.0123", "not run", "one"):
        assert words in text
    with pytest.raises(UsageError):
        pgimp.open(folder)


def test_the_citation_is_that_of_the_file():
    held = YAML(typ="safe").load((ROOT / "CITATION.cff").read_text())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert held["version"] == project["version"]
    assert held["license"] == project["license"] == citation.LICENCE
    assert held["title"] == project["name"] == citation.TITLE
    assert held["authors"] == [{"name": citation.AUTHOR}]
    assert held["abstract"] == project["description"]
    (paper,) = held["references"]
    own = dict(citation.PAPER)
    authors = [(one["family-names"], one["given-names"]) for one in paper["authors"]]
    assert authors == [*own.pop("authors")]
    assert {name: paper[name] for name in own} == own


def test_timings_of_ranks():
    text = str(parts.timing_table({"P2G": [1.0, 3.0], "G2P": [2.0, 1.0]}, 4.0))
    assert "rank 1" in text and "50 %" in text and "other" in text
    many = str(parts.timing_table({"P2G": [1.0] * 9 + [2.0]}, 4.0))
    assert "greatest" in many and "rank 1" not in many
    assert parts.timing_table({}, 1.0) == "" and BEGINNING.startswith("<!DOCTYPE")


def test_markdown_of_a_study():
    title, found = to_html("# One <b>\n\ntext `a<b` on\ntwo lines\n\n- x\n- y\n")
    assert title == "One <b>"
    assert found[0] == "<p>text <code>a&lt;b</code> on two lines</p>"
    assert found[1].count("<li>") == 2


def damaged(start):
    """Values in place of those of a start, one at a time."""
    for key, value in start.items():
        for wrong in (None, "x", [], {}, -1, [1, "a"], {"a": [1]}, 1e305):
            yield start | {key: wrong}
        if isinstance(value, dict):
            for name in value:
                yield start | {key: value | {name: ["x"]}}


def test_a_damaged_run_json_costs_no_more_than_its_entries(copied):
    """Each entry of another kind: the page is made without it, or the file is said to be wrong."""
    path = copied / "run.json"
    content = json.loads(path.read_text())
    made = 0
    with (
        patch.object(drawings, "pictures", lambda *_: Markup()),
        patch.object(drawings, "history_figure", lambda *_: Markup()),
    ):
        for start in damaged(content["starts"][0]):
            path.write_text(json.dumps(content | {"starts": [start]}))
            try:
                assert "<h2>Balances</h2>" in report_of_run(copied)
                made += 1
            except UsageError as error:
                assert "run.json is damaged" in str(error)
    assert made > 100


def test_a_damaged_history_is_told_and_the_rest_stands(copied, report):
    """Without a column, with another's name, text or numbers beyond all use in it."""
    path = copied / "history.csv"
    text = path.read_text()
    head, *lines = text.splitlines(keepends=True)
    rows = [line.split(",") for line in text.splitlines()]
    wrong = {name: text.replace(name, f"x{name}", 1) for name in ("time", "mass", "strain-energy")}
    wrong |= {
        "has no column kinetic-energy": "\n".join(
            ",".join(row[:k] + row[k + 1 :])
            for row in rows
            for k in [rows[0].index("kinetic-energy")]
        ) + "\n",
        "out of range": head + ",".join(["-1e305"] * len(rows[0])) + "\n",
        "line 2 is damaged": head + lines[0].replace(",", ",abc", 1),
    }  # fmt: skip
    for why, content in wrong.items():
        path.write_text(content)
        status, _, said = report(copied)
        assert (status, said) == (0, "")
        page = (copied / "report.html").read_text()
        assert why in page and "damaged" in page and "<h2>Case</h2>" in page
