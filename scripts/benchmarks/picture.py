"""What the benchmarks' pictures share."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from pgimp.utilities.plot.style import STYLE

plt.rcParams.update(STYLE | {"font.size": 9})


def save(figure, path):
    figure.savefig(path)
    plt.close(figure)
    print(f"benchmark: {path}", flush=True)
