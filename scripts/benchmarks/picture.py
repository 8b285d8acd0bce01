"""What the benchmarks' pictures share."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

plt.rcParams.update(
    {
        "font.size": 9,
        "axes.grid": True,
        "grid.color": "#e4e4e4",
        "axes.axisbelow": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "legend.frameon": False,
        "figure.constrained_layout.use": True,
        "savefig.dpi": 110,
    }
)


def save(figure, path):
    """Write the picture."""
    figure.savefig(path)
    plt.close(figure)
    print(f"benchmark: {path}", flush=True)
