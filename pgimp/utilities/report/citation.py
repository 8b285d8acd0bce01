"""How to cite pgimp; CITATION.cff says the same, which a test compares."""

from __future__ import annotations

TITLE = "pgimp"
AUTHOR = "The pgimp developers"
LICENCE = "MIT"
#: Authors, title, journal, volume, issue, first and last page, year of the paper of the method.
PAPER = {
    "authors": (("Bardenhagen", "S. G."), ("Kober", "E. M.")),
    "title": "The Generalized Interpolation Material Point Method",
    "journal": "CMES - Computer Modeling in Engineering & Sciences",
    "volume": 5,
    "issue": 6,
    "start": 477,
    "end": 495,
    "year": 2004,
}


def software(version: str, commit: str = "") -> str:
    """Return the citation of the program as text."""
    at = f", commit {commit[:12]}" if commit else ""
    return f"{AUTHOR}: {TITLE}, version {version}{at} ({LICENCE} licence)."


def paper() -> str:
    """Return the citation of the paper as text."""
    p = PAPER
    names = " and ".join(f"{given} {family}" for family, given in p["authors"])  # type: ignore[attr-defined]
    return (
        f"{names}: {p['title']}. {p['journal']} {p['volume']}({p['issue']}), "
        f"{p['start']}-{p['end']}, {p['year']}."
    )


def bibtex(version: str) -> str:
    """Return both citations for BibTeX."""
    p = PAPER
    names = " and ".join(f"{family}, {given}" for family, given in p["authors"])  # type: ignore[attr-defined]
    return (
        f"@software{{pgimp,\n  author = {{{{{AUTHOR}}}}},\n  title = {{{TITLE}}},\n"
        f"  version = {{{version}}}\n}}\n\n"
        f"@article{{gimp,\n  author = {{{names}}},\n  title = {{{p['title']}}},\n"
        f"  journal = {{{str(p['journal']).replace('&', chr(92) + '&')}}},\n"
        f"  volume = {{{p['volume']}}},\n  number = {{{p['issue']}}},\n"
        f"  pages = {{{p['start']}--{p['end']}}},\n  year = {{{p['year']}}}\n}}"
    )
