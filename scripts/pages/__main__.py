"""Writes the pages of docs/ that show measurements, each from its text and its tables.

A line ``{{ NAME }}`` of ``texts/PAGE.md`` stands for ``tables/NAME.md``, which the script that
measures it writes: scripts/benchmark, scripts/methods, scripts/pareto and others. Of ``choices``
the table is made of pgimp's own rules. Whoever changes a page changes its text, and runs this
again.

    python scripts/pages [--check]

With --check nothing is written, and the exit status is 1 if a page is not what this would write.
"""

import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
DOCS = HERE.parents[1] / "docs"
NOTE = "<!-- Written by scripts/pages from scripts/pages/texts/{name} and the tables beside it. -->"


def page(text: Path) -> str:
    """The page of a text."""

    def table(place: re.Match) -> str:
        if place[1] == "choices":
            from choices import rules

            return rules()
        return (HERE / "tables" / f"{place[1]}.md").read_text(encoding="utf-8").strip()

    body = re.sub(r"^\{\{ ([\w-]+) \}\}$", table, text.read_text(encoding="utf-8"), flags=re.M)
    return f"{body.rstrip()}\n\n{NOTE.format(name=text.name)}\n"


def main() -> int:
    """Write or check all pages."""
    status = 0
    for text in sorted((HERE / "texts").glob("*.md")):
        path, written = DOCS / text.name, page(text)
        if path.exists() and path.read_text(encoding="utf-8") == written:
            continue
        if "--check" in sys.argv[1:]:
            print(f"pages: docs/{text.name} is not what scripts/pages writes", file=sys.stderr)
            status = 1
        else:
            path.write_text(written, encoding="utf-8")
    return status


if __name__ == "__main__":
    sys.exit(main())
