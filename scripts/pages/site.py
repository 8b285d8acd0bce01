"""What the site takes from outside docs/: the cases with their pages and pictures, the licence.

The pages are read on code hosts too, where links lead from docs/ to ../cases/. The site has the
folder cases/ within it, so here these links lead there.
"""

from pathlib import Path

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[2]
ENDINGS = (".md", ".yaml", ".py", ".png", ".obj")


def on_files(files, config):
    """Add what pages link to."""
    paths = [ROOT / "LICENSE", ROOT / "CHANGELOG.md", ROOT / "pyproject.toml"]
    paths += [path for path in sorted((ROOT / "cases").rglob("*")) if path.suffix in ENDINGS]
    for path in paths:
        name = path.relative_to(ROOT)
        if not any(part.endswith(".out") or part == "__pycache__" for part in name.parts):
            files.append(File.generated(config, name.as_posix(), abs_src_path=str(path)))
    return files


def on_page_markdown(markdown, page, config, files):
    """Lead links to where their targets are in the site."""
    if page.file.src_uri.startswith("cases/"):
        return markdown.replace("](../docs/", "](../")
    return markdown.replace("](../", "](")
