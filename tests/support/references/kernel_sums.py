"""Sums over the particles of a rank of `kernel_driver`."""

import numpy as np
from kernel_driver import MATERIALS

from pgimp.kernels.data.arguments import KernelScene
from pgimp.kernels.sums.sums import SUMS, fastest_rate, layer_sums


def sums_of(rank, D, bodies, material_of):
    """Result of `layer_sums`, (layers, bodies, columns)."""
    sums = np.zeros((rank.slab.layers, bodies, SUMS))
    population = rank.population
    setting = KernelScene((), rank.frame, rank.setting.identity, MATERIALS, material_of)
    layer_sums(setting, population.up_to_date(), population.ordered, sums)
    return sums


def rate_of(rank, D, material_of):
    """Result of `fastest_rate`."""
    population = rank.population
    setting = KernelScene((), rank.frame, rank.setting.identity, MATERIALS, material_of)
    return fastest_rate(setting, population.up_to_date(), population.order, True)
