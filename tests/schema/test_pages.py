"""Pages of the documentation as messages name them: in a checkout, and installed."""

import re

import pytest
from pages import DOCS

from pgimp.running.accuracy.rules import RULES, Indicator, line
from pgimp.schema import pages


@pytest.fixture
def installed(monkeypatch, tmp_path):
    """The package is elsewhere, without the pages beside it."""
    monkeypatch.setattr(pages, "__file__", str(tmp_path / "lib/pgimp/schema/pages.py"))
    monkeypatch.setattr(pages, "_site", lambda: "")


def test_titles_and_sections_are_those_of_the_pages():
    for link in {rule.page for rule in RULES.values()} | set(pages.TITLES):
        name, _, section = link.partition("#")
        text = (DOCS / name).read_text()
        assert text.startswith(f"# {pages.TITLES[name]}\n")
        heads = [head.lower().replace(" ", "-") for head in re.findall(r"^##+ (.*)", text, re.M)]
        assert not section or section in heads, link


def test_an_installed_pgimp_names_what_can_be_found(installed, monkeypatch):
    assert pages.page("methods.md#reasons") == (
        "the page 'Which method', section 'Reasons', of pgimp's documentation"
    )
    assert pages.page("report.md").startswith("the page 'Reports, and")
    assert line([Indicator("lost", 0.06)]).endswith("'Reasons', of pgimp's documentation")
    monkeypatch.setattr(pages, "_site", lambda: "https://pgimp.example/")
    assert pages.page("limits.md#further-limits") == (
        "https://pgimp.example/limits.html#further-limits"
    )
    assert pages.page("limits.md") == "https://pgimp.example/limits.html"


def test_a_checkout_has_the_pages_themselves():
    assert pages.page("methods.md#reasons") == "docs/methods.md#reasons"
