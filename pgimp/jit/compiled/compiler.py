"""Kernels by tracing (`pgimp.jit.tracing`), and others by Numba's compiler.

Numba compiles what counts references, as kernels that make arrays, and functions from outside the
package. It does so without the passes that they do not need. A kernel consists of some ten to some
hundred functions, chosen by types, that are inlined into it. Each is kept on disk in the form that
LLVM needs to inline it. Machine code is made and kept of kernels only.
"""

import gc
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from types import FunctionType
from typing import Self

import llvmlite.binding as llvm
import numba
from numba.core import compiler
from numba.core import typed_passes as typed
from numba.core import untyped_passes as untyped
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_machinery import PassManager
from numba.core.environment import lookup_environment

import pgimp.jit.compiled.arguments  # noqa: F401  so that records are passed whole
from pgimp.jit.compiled.cache import Store
from pgimp.jit.outside import NumbaObject, part_of
from pgimp.jit.tracing.kernel import compiled

with suppress(AttributeError):
    # Numba's timers are told of every call of LLVM: a fiftieth of the time of a compilation.
    llvm.ffi.lib._lock._cblist.clear()

#: Numba's passes for closures, ``with``, literals, array expressions and its own loops, which the
#: package does not contain.
_NOT_NEEDED = (
    untyped.WithLifting, untyped.InlineClosureLikes, untyped.RewriteDynamicRaises,
    untyped.MakeFunctionToJitFunction, untyped.InlineInlinables, untyped.FindLiterallyCalls,
    untyped.LiteralUnroll, untyped.LiteralPropagationSubPipelinePass, typed.InlineOverloads,
    typed.NopythonRewrites, typed.NoPythonSupportedFeatureValidation, typed.DumpParforDiagnostics,
)  # fmt: skip


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


class _Linked(JITCodeLibrary):
    """A part of kernels, linked into them: it has no machine code of its own."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: there is no entry for Python."""
        self._ensure_finalized()
        return 0

    def serialize_using_object_code(self) -> NumbaObject:
        """Return its data for the disk cache: there is no machine code."""
        return self.serialize_using_bitcode()

    @property
    def codegen(self) -> Self:
        """Nothing: its environment is set in the kernel that links it."""
        return self

    def set_env(self, name: str, environment: NumbaObject) -> None:
        """See `codegen`."""


def _captured(function: FunctionType) -> tuple[object, ...] | None:
    """Identity of a function of the package among others of its name; None if unknown.

    It consists of its line and of the variables captured from the function that made it.
    """
    if function.__module__.partition(".")[0] != "pgimp" or function.__defaults__:
        return None
    found: list[object] = [function.__code__.co_firstlineno]
    for cell in function.__closure__ or ():
        content = cell.cell_contents
        if isinstance(content, bool | int | float | str):
            found.append(content)
        elif isinstance(content, tuple) and all(isinstance(each, int | float) for each in content):
            found.append(content)
        elif isinstance(content, FunctionType) and not content.__closure__:
            if (inner := _captured(content)) is None:
                return None
            found.append((content.__module__, content.__qualname__, *inner))
        else:
            return None
    return tuple(found)


class Compiler(compiler.Compiler):
    """Numba's compiler, but kernels are traced, and without garbage collection.

    Python would search its many objects for garbage again and again, which takes an eighth of the
    time; the garbage is found afterwards.

    Attributes
    ----------
    folder : Path or None
        Folder for parts of kernels; None: not kept.
    """

    folder: Path | None = None

    def define_pipelines(self) -> list[PassManager]:
        """Return Numba's pipeline, for the package's own functions without unneeded passes."""
        pipelines = super().define_pipelines()
        if self.state.func_id.modname.partition(".")[0] == "pgimp":
            for pipeline in pipelines:
                pipeline.passes = [
                    (one, what) for one, what in pipeline.passes if one not in _NOT_NEEDED
                ]
                pipeline.finalize()
        return pipelines

    def _compile_core(self) -> NumbaObject:
        if not gc.isenabled():  # as within the compilation of another function
            return self._compile()
        gc.disable()
        try:
            return self._compile()
        finally:
            gc.enable()

    def _compile(self) -> NumbaObject:
        if self.state.flags.no_cpython_wrapper:
            return self._part()
        codegen = self.state.targetctx.codegen()
        self.state.library = _Kernel(codegen, self.state.func_id.func_qualname)
        self.state.library.enable_object_caching()
        if not self.state.flags.nrt:
            found = compiled(self.state, self.state.library)
        else:
            found = super()._compile_core()
        for variable in found.library._final_module.global_variables:
            if environment := lookup_environment(variable.name):
                codegen.set_env(variable.name, environment)
        return found

    def _part(self) -> NumbaObject:
        """Find a part of kernels on disk, or compile and keep it."""
        state, function = self.state, self.state.func_id
        function.is_part = True  # see `pgimp.jit.compiled.arguments`
        store, name = None, f"{function.modname}.{function.func_qualname}"
        captured = _captured(function.func)
        part = part_of(state.args)
        if self.folder and captured is not None and part is not None:
            store = Store(self.folder / f"{part}-parts".lstrip("-"))
            # Names within LLVM must equal the names that other processes give.
            function.unique_id = int(sha256(repr(captured).encode()).hexdigest()[:12], 16)
            function.unique_name = f"{function.func_qualname}${function.unique_id}"
        codegen = state.targetctx.codegen()
        flags = state.flags.get_mangle_string()
        key = (state.args, name, captured, flags, codegen.magic_tuple(), numba.__version__)
        if store and (found := store.load(name, key, self._rebuilt)):
            state.targetctx.insert_user_function(found.entry_point, found.fndesc, [found.library])
            return found
        state.library = _Linked(codegen, state.func_id.func_qualname)
        found = super()._compile_core()
        if store and not found.library.has_dynamic_globals and not found.lifted:
            found.fndesc.typemap = found.fndesc.calltypes = None
            code = found.library.serialize_using_bitcode()
            kept = (code, found.fndesc, found.environment, found.signature, found.reload_init)
            store.save(name, key, kept)
        return found

    def _rebuilt(self, kept: NumbaObject) -> NumbaObject:
        """Rebuild the result of a compilation from the cache."""
        (name, _, code), fndesc, environment, signature, reload_init = kept
        context = self.state.targetctx
        library = _Linked(context.codegen(), name)
        library._final_module = llvm.parse_bitcode(code)
        library._finalize_final_module()
        entry = context.get_executable(library, fndesc, environment)
        return compiler.compile_result(
            target_context=context, typing_context=context.typing_context, library=library,
            environment=environment, entry_point=entry, fndesc=fndesc, type_annotation="",
            signature=signature, objectmode=False, lifted=(), reload_init=reload_init,
            referenced_envs=(),
        )  # fmt: skip
