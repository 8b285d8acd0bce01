"""Numba's compiler, which does not search for garbage while it compiles."""

import gc
from typing import Any

from numba.core import compiler


class Compiler(compiler.Compiler):
    """Numba's, whose many objects Python would search for garbage again and again.

    That takes an eighth of the time; what there is of it is found afterwards.
    """

    def _compile_core(self) -> Any:
        if not gc.isenabled():  # as within the compilation of another function
            return super()._compile_core()
        gc.disable()
        try:
            return super()._compile_core()
        finally:
            gc.enable()
