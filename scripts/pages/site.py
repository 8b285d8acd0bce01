"""What the site takes from outside docs/: the cases with their pages and pictures, the licence.

The pages are read on code hosts too, where links lead from docs/ to ../cases/. The site has the
folder cases/ within it, so here these links lead there. The gallery, the pages of the cases and
their notebooks are made here from cases/ (scripts/gallery); last, all links are followed.
"""

import logging
import sys
from pathlib import Path

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "scripts"))
from gallery.facts import cases  # noqa: E402
from gallery.links import dead  # noqa: E402
from gallery.notebook import notebook  # noqa: E402
from gallery.pages import PLACE, case_page, gallery  # noqa: E402

#: A warning here ends `mkdocs build --strict` with status 1.
LOG = logging.getLogger("mkdocs.hooks.site")
ENDINGS = (".md", ".yaml", ".py", ".png", ".obj")


def on_files(files, config):
    """Add what pages link to."""
    paths = [ROOT / "LICENSE", ROOT / "CHANGELOG.md", ROOT / "pyproject.toml"]
    paths += [path for path in sorted((ROOT / "cases").rglob("*")) if path.suffix in ENDINGS]
    for path in paths:
        name = path.relative_to(ROOT)
        if not any(part.endswith(".out") or part == "__pycache__" for part in name.parts):
            files.append(File.generated(config, name.as_posix(), abs_src_path=str(path)))
    for path in sorted((ROOT / "scripts" / "gallery" / "assets").iterdir()):
        files.append(File.generated(config, f"assets/{path.name}", abs_src_path=str(path)))
    for case in cases():
        files.append(File.generated(config, f"cases/{case.key}.md", content=case_page(case)))
        written = notebook(case)
        files.append(File.generated(config, f"cases/notebooks/{case.key}.ipynb", content=written))
    return files


def on_page_markdown(markdown, page, config, files):
    """Lead links to where their targets are in the site; the first page gets the gallery."""
    if page.file.src_uri.startswith("cases/"):
        return markdown.replace("](../docs/", "](../")
    if page.file.src_uri == "index.md":
        shown = gallery(cases())
        markdown = PLACE.sub(lambda _: shown, markdown)
    up = "../" * page.file.src_uri.count("/")  # from its folder to docs/
    return markdown.replace(f"]({up}../", f"]({up}")


def on_post_build(config):
    """Follow the links of all pages."""
    for line in dead(Path(config.site_dir)):
        LOG.warning("dead link or picture: %s", line)
