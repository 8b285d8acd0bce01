"""Links and pictures of a built site: each leads to a file, and to a place in it."""

from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

#: What a browser loads by itself; a link may lead elsewhere, these may not.
_LOADED = {"img": "src", "script": "src", "link": "href", "source": "src", "iframe": "src"}
#: The page of a server for what is not there has addresses from the root of the server.
_SERVER = "404.html"


class _Page(HTMLParser):
    """The places of a page, and where it leads."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.places: set[str] = set()
        self.targets: list[tuple[str, bool]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note a tag."""
        own = dict(attrs)
        self.places.update(own[name] or "" for name in ("id", "name") if name in own)
        if tag == "a" and own.get("href"):
            self.targets.append((own["href"] or "", False))
        elif own.get(_LOADED.get(tag, "")):
            self.targets.append((own[_LOADED[tag]] or "", own.get("rel") != "canonical"))


def dead(site: Path) -> Iterator[str]:
    """A line for each link, picture, script or style that is not there, or is on another host."""
    files = sorted(path for path in site.rglob("*.html") if path.name != _SERVER)
    pages = {path.resolve(): _Page(path.read_text(encoding="utf-8")) for path in files}
    for path, page in pages.items():
        for target, loaded in dict.fromkeys(page.targets):
            parts = urlsplit(target)
            if parts.scheme == "data" or (parts.scheme and not loaded):
                continue
            where = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            wrong = (
                parts.scheme
                or parts.netloc
                or not where.is_file()
                or (where in pages and parts.fragment and not _leads(pages[where], parts.fragment))
            )
            if wrong:
                yield f"{path.relative_to(site.resolve())}: {target}"


def _leads(page: _Page, fragment: str) -> bool:
    return unquote(fragment) in page.places
