"""Materials written into files, as users of the package would."""

LAW = """
from typing import Literal, NamedTuple
import pgimp
from pgimp.physics.materials import Material
from {helper} import faster

FACTOR = {factor}

class LawParameters(NamedTuple):
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt):
        return {stress}

    @staticmethod
    def energy(material, F, J, sigma):
        return 0.0

    @staticmethod
    def speed(material, F, J):
        return {speed}

@pgimp.register_material
class Law(Material):
    model: Literal["law"]

    def parameters(self):
        return LawParameters(self.density)
"""


HELPER = """
import numba

@numba.njit
def faster(c):
    return {times} * c
"""


def write_law(folder, factor=2.0, times=1.0, speed="faster(FACTOR)", stress="sigma", helper="aid"):
    folder.mkdir(exist_ok=True)
    text = LAW.format(factor=factor, speed=speed, stress=stress, helper=helper)
    (folder / "law.py").write_text(text)
    (folder / f"{helper}.py").write_text(HELPER.format(times=times))


def law(stress="sigma", speed="FACTOR", factor=2.0):
    text = LAW.format(factor=factor, speed=speed, stress=stress, helper="math")
    return text.replace("from math import faster", "from math import sqrt, log, exp")
