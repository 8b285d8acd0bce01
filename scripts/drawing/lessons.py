"""Pictures of the tutorials: each page is followed, and the figures that it makes are taken."""

import shutil

from common import PICTURES, RUNS, shrink
from tutorials.follow import TUTORIALS, follow


def lesson(page, redraw):
    """Follow a tutorial, unless it is only to be drawn again, and take the figures it shows."""
    folder = RUNS / "tutorials" / page
    if not (redraw and folder.exists()):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        follow(page, folder)
    text = (TUTORIALS / f"{page}.md").read_text(encoding="utf-8")
    for made in sorted(folder.rglob("*.png")):
        path = PICTURES / f"tutorial-{page}-{made.stem}.png"
        if path.name in text:
            shutil.copy(made, path)
            shrink(path)


def tutorial_footing(redraw):
    """Force over settlement, and shear."""
    lesson("footing", redraw)


def tutorial_impact(redraw):
    """Energies, the bar, and the study of its cells."""
    lesson("impact", redraw)


def tutorial_dam_break(redraw):
    """Water and float, their ways, and the gauge."""
    lesson("dam-break", redraw)


def tutorial_hopkinson(redraw):
    """Stress at the gauges, and the specimen's curve."""
    lesson("hopkinson", redraw)


def tutorial_own_material(redraw):
    """Stress along a path, and the top of the column."""
    lesson("own-material", redraw)
