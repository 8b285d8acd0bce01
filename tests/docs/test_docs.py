"""scripts/docs: the pages become a site without a warning."""

import json
import os
import shutil
import sys
from pathlib import Path

import pytest
from browser import CHROMIUM, Browser
from gallery.facts import cases
from processes import run

pytestmark = pytest.mark.slow(40)

ROOT = Path(__file__).resolve().parents[2]
#: Pictures that are not there, when all have been asked for.
LOST = """(async () => {
  const all = [...document.images];
  all.forEach(each => each.loading = 'eager');
  await Promise.all(all.map(each => each.complete || new Promise(
    done => each.onload = each.onerror = done)));
  return all.filter(each => !each.naturalWidth).map(each => each.src);
})()"""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site. A link that leads nowhere is a warning of its build, which ends it."""
    folder = tmp_path_factory.mktemp("built") / "site"
    words = ["-m", "mkdocs", "build", "--strict", "-f", str(ROOT / "scripts/pages/mkdocs.yml")]
    env = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    done = run([sys.executable, *words, "-d", str(folder)], env=env)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def test_the_site_is_built_and_can_be_searched(site):
    for name in ("index", "running", "cases/index", "cases/reference"):
        assert (site / f"{name}.html").is_file()
    assert (site / "cases" / "pictures" / "block3d.png").is_file()
    found = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))["docs"]
    places = {entry["location"] for entry in found if "restart" in entry["title"].lower()}
    assert "running.html#stopping-and-restarting" in places


def test_the_first_page_shows_every_case(site):
    first = (site / "index.html").read_text(encoding="utf-8")
    for case in cases():
        assert f'src="cases/pictures/{case.key}.png"' in first, case.name
        assert f'href="cases/{case.key}.html"' in first, case.name
        assert f"<pre><code>{case.command}</code></pre>" in first, case.name
        assert (site / "cases" / case.path).read_text(encoding="utf-8") == case.text
        assert (site / "cases" / "notebooks" / f"{case.key}.ipynb").is_file()
    assert "gallery -->" not in first


def test_pages_are_read_from_the_disk(site, tmp_path):
    """Without a server: nothing is lost or too wide, and what is typed into the box is found."""
    assert CHROMIUM, "chromium is not installed: apt-get install chromium"
    browser = Browser(tmp_path)
    try:
        for name in ("index", "cases/excavation", "materials"):
            for width in (1400, 390):
                browser.open((site / f"{name}.html").as_uri(), width)
                assert browser.find(LOST) == []
                assert browser.find("document.documentElement.scrollWidth") <= width
                assert browser.failures() == []
        browser.open((site / "index.html").as_uri(), 1400)
        browser.find("document.querySelector('.md-search__input').focus()")
        browser.type("excavation")
        results = "[...document.querySelectorAll('.md-search-result__link')].map(one => one.href)"
        browser.wait(f"{results}.length")
        assert any("/cases/excavation.html" in address for address in browser.find(results))
    finally:
        browser.close()


def test_the_script_says_what_it_does():
    done = run([str(ROOT / "scripts" / "docs"), "--help"])
    assert done.returncode == 0
    assert "build/site" in done.stdout


def test_a_page_of_measurements_follows_its_table(tmp_path):
    """As when a script has measured again: the page is written as a whole, the others stay."""
    for name in ("scripts/pages", "docs"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    table = tmp_path / "scripts" / "pages" / "tables" / "courant.md"
    old = table.read_text(encoding="utf-8")
    table.write_text(old.replace("| mpm | 0.27 |", "| mpm | 0.99 |"), encoding="utf-8")
    words = [sys.executable, str(tmp_path / "scripts" / "pages")]
    assert run([*words, "--check"]).returncode == 1
    assert run(words).returncode == 0
    assert run([*words, "--check"]).returncode == 0
    for page in (tmp_path / "docs").glob("*.md"):
        before = (ROOT / "docs" / page.name).read_text(encoding="utf-8")
        after = page.read_text(encoding="utf-8")
        assert after == before.replace("| mpm | 0.27 |", "| mpm | 0.99 |"), page.name
        assert (after != before) == (page.name == "hard-cases.md")
