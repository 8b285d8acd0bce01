"""Kernels by tracing (`pgimp.jit.tracing`); functions from outside the package by Numba alone."""

import gc
from contextlib import suppress

import llvmlite.binding as llvm
from numba.core import compiler
from numba.core.codegen import JITCodeLibrary
from numba.core.environment import lookup_environment

from pgimp.jit.outside import NumbaObject

with suppress(AttributeError):
    # Numba's timers are told of every call of LLVM: a fiftieth of the time of a compilation.
    llvm.ffi.lib._lock._cblist.clear()


class _Kernel(JITCodeLibrary):
    """A kernel, with an unoptimised entry for Python.

    An entry unpacks dozens of arrays, once a step. Optimising it takes a tenth of the compile time,
    and has no visible effect on the time of a run.
    """

    def add_ir_module(self, module: NumbaObject) -> None:
        """Add the kernel, or its entry."""
        for function in module.functions:
            if function.name.startswith("_ZN7cpython"):  # cpython::, mangled
                function.attributes.add("noinline")
                function.attributes.add("optnone")
        super().add_ir_module(module)


class Compiler(compiler.Compiler):
    """Compiler of kernels, without garbage collection.

    Python would search its many objects for garbage again and again, which takes an eighth of the
    time; the garbage is found afterwards.
    """

    #: By this kernels are known among Numba's functions.
    traces = True

    def _compile_core(self) -> NumbaObject:
        if not gc.isenabled():  # as within the compilation of another function
            return self._compile()
        gc.disable()
        try:
            return self._compile()
        finally:
            gc.enable()

    def _compile(self) -> NumbaObject:
        state = self.state
        codegen = state.targetctx.codegen()
        state.library = _Kernel(codegen, state.func_id.func_qualname)
        state.library.enable_object_caching()
        if state.flags.forceinline and state.flags.nrt:  # from outside: it may do anything
            found = super()._compile_core()
        else:
            from pgimp.jit.tracing.kernel import compiled  # not where all kernels are on disk

            found = compiled(state)
        for variable in found.library._final_module.global_variables:
            if environment := lookup_environment(variable.name):
                codegen.set_env(variable.name, environment)
        return found
