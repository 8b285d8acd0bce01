"""The gallery on the first page of the site, and a page for each case."""

import re
from html import escape

from gallery.facts import Facts, studies
from gallery.trades import TRADES

#: The part of docs/index.md in whose place the gallery is: what code hosts show instead.
PLACE = re.compile(r"<!-- gallery -->.*?<!-- end of the gallery -->", re.DOTALL)

#: Another case in the text of one that lies in a folder of cases/.
_OTHER = re.compile(r"\.\./([\w/-]+)\.yaml")

_CARD = """\
<article>
<a href="cases/{key}.html"><img loading="lazy" src="cases/pictures/{key}.png" alt="{name}"></a>
<h3 id="{key}"><a href="cases/{key}.html">{name}</a> <small>{dimensions}D</small></h3>
<p>{title}.</p>
<dl><dt>verifies</dt> <dd>{verifies}</dd> <dt>size</dt> <dd>{size}</dd></dl>
<pre><code>{command}</code></pre>
<p><a href="cases/{key}.html#the-case-file">case file</a>
<a href="cases/notebooks/{key}.ipynb" download>notebook</a></p>
</article>"""
#: Without contents at its side a page has room for the lines of a case.
_PAGE = """\
---
hide: [toc]
---

# {name}

<p>{title}.</p>

![{shows}](pictures/{key}.png)

{remarks}

<dl class="facts">
<dt>physics</dt> <dd>{physics}</dd>
<dt>verifies</dt> <dd>{verifies}</dd>
<dt>size</dt> <dd>{size}</dd>
</dl>

In a checkout:

```sh
{command}
```

A copy to change, with what belongs to it:

```sh
pgimp init {name}
```

[The notebook](notebooks/{key}.ipynb) writes such a copy, changes values, runs it and draws
results, in Jupyter or VS Code. More cases: [{trade}](../docs/index.md#{anchor}).

## The case file

[{path}]({path}) says above its first key what is known exactly, and which numbers to expect.

```yaml title="cases/{path}"
{text}
```
"""


def gallery(found: list[Facts]) -> str:
    """All cases as cards, by trade; and the studies."""
    by_name = {case.name: case for case in found}
    ways = (f'<a href="#{anchor(trade)}">{trade}</a>' for trade in TRADES)
    parts = [f'<p class="trades">{" ".join(ways)} <a href="#pages">Pages</a></p>']
    for trade, names in TRADES.items():
        cards = "\n".join(_card(by_name[name]) for name in names if name in by_name)
        parts += [f"## {trade}", f'<div class="gallery">\n{cards}\n</div>']
    parts.append("Studies run a case many times:")
    parts.append("\n".join(_study(study) for study in studies()))
    return "\n\n".join(parts)


def case_page(case: Facts) -> str:
    """The page of a case, which lies in cases/."""
    trade = next((trade for trade, names in TRADES.items() if case.name in names), "Methods")
    more = {"trade": trade, "anchor": anchor(trade), "text": case.text.rstrip()}
    physics = _OTHER.sub(_link, _html(case.parts["Physics"]))
    more |= {"physics": physics, "path": case.path}
    return _PAGE.format(**_shared(case), remarks=case.remarks, **more)


def anchor(title: str) -> str:
    """The anchor of a heading."""
    return title.lower().replace(" ", "-")


def _link(other: re.Match) -> str:
    return f'<a href="{other[1].replace("/", "-")}.html">{other[1]}</a>'


def _card(case: Facts) -> str:
    return _CARD.format(**_shared(case), dimensions=case.dimensions)


def _shared(case: Facts) -> dict[str, str]:
    said = {"title": case.title, "verifies": case.verifies, "size": case.parts["Size"].rstrip(".")}
    plain = {"key": case.key, "name": case.name, "shows": case.shows, "command": case.command}
    return plain | {key: _html(text) for key, text in said.items()}


def _html(text: str) -> str:
    return re.sub(r"`(.+?)`", r"<code>\1</code>", escape(text))


def _study(study: Facts) -> str:
    name = study.name
    title = study.title.partition(": `")[0]
    return f"- [{name}](../cases/{study.path}): {title}, `pgimp study cases/{study.path}`"
