"""scripts/docs: the pages become a site without a warning."""

import json
import os
import shutil
import sys
from pathlib import Path

import pytest
from processes import run

pytestmark = pytest.mark.slow(30)

ROOT = Path(__file__).resolve().parents[2]


def test_the_site_is_built_and_can_be_searched(tmp_path):
    words = ["-m", "mkdocs", "build", "--strict", "-f", str(ROOT / "scripts/pages/mkdocs.yml")]
    env = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    done = run([sys.executable, *words, "-d", str(tmp_path / "site")], env=env)
    assert done.returncode == 0, done.stdout + done.stderr
    site = tmp_path / "site"
    for name in ("index", "running", "cases/index", "cases/reference"):
        assert (site / f"{name}.html").is_file()
    assert (site / "cases" / "pictures" / "block3d.png").is_file()
    found = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))["docs"]
    places = {entry["location"] for entry in found if "restart" in entry["title"].lower()}
    assert "running.html#stopping-and-restarting" in places


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
