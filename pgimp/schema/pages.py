"""Pages of the documentation, as messages name them.

A checkout has the page itself. An installed pgimp has an address, if its project has one for the
documentation, and else the title and the section: those of the site that `scripts/docs` builds.
"""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path

#: Titles of the pages that messages name; a test compares them with the pages.
TITLES = {
    "case-file.md": "The case file",
    "contact.md": "Contact",
    "error-against-cost.md": "Error against cost",
    "hard-cases.md": "Hard cases",
    "limits.md": "Limits",
    "metals.md": "Metals",
    "methods.md": "Which method",
    "report.md": "Reports, and what is known of the errors of a run",
    "soils-and-fluids.md": "Soils, fluids and gases",
    "walls.md": "Walls",
    "waves.md": "Waves",
}


def page(link: str) -> str:
    """Return how to find a page, or a section of it.

    Parameters
    ----------
    link : str
        As links between pages have it, ``methods.md#reasons``.
    """
    name, _, section = link.partition("#")
    if (Path(__file__).parents[2] / "docs" / name).is_file():
        return f"docs/{link}"
    if site := _site():
        return f"{site.rstrip('/')}/{name.removesuffix('.md')}.html{'#' * bool(section)}{section}"
    part = f", section '{section.replace('-', ' ').capitalize()}'" if section else ""
    return f"the page '{TITLES[name]}'{part}, of pgimp's documentation"


@cache
def _site() -> str:
    """Address of the documentation that the installed project names; empty without any."""
    try:
        named = metadata("pgimp").get_all("Project-URL") or []
    except PackageNotFoundError:
        return ""
    links = dict(entry.split(", ", 1) for entry in named if ", " in entry)
    return links.get("Documentation", "")
