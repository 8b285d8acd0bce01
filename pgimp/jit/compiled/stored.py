"""A kernel as the disk has it: machine code, and its instructions, which are rarely needed.

Numba reads the instructions of every kernel that it loads, in case another function is compiled
together with it. That takes two thirds of the time in which a kernel is loaded.
"""

from collections.abc import Sequence
from itertools import chain

import llvmlite.binding as llvm
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompileResult, compile_result

from pgimp.jit.outside import NumbaObject


class _Loaded(JITCodeLibrary):
    """A kernel from the disk, whose instructions are read when they are asked for."""

    bitcode = b""

    def _get_module_for_linking(self) -> NumbaObject:
        if self._shared_module is None:
            self._shared_module = llvm.parse_bitcode(self.bitcode)
        return self._shared_module


def reduced(result: NumbaObject) -> tuple:
    """What is to be kept of a compiled kernel: the names that it defines, and what Numba keeps."""
    module = result.library._get_module_for_linking()
    symbols = chain(module.functions, module.global_variables)
    return [one.name for one in symbols if not one.is_declaration], *result._reduce()


def rebuilt(target: NumbaObject, kept: Sequence) -> CompileResult:
    """The compiled kernel of `reduced`, ready to be called."""
    names, (name, _, (code, bitcode)), description, environment, signature, *rest = kept
    objectmode, lifted, annotation, reload_init, environments = rest
    for initialise in reload_init:
        initialise()
    codegen = target.codegen()
    library = _Loaded(codegen, name)
    library.bitcode = bitcode
    library.enable_object_caching()
    library._set_compiled_object(code)
    library._finalize_final_module()
    codegen._engine._defined_symbols.update(names)
    entry = target.get_executable(library, description, environment)
    for one in environments:
        codegen.set_env(one.env_name, one)
    return compile_result(
        target_context=target, typing_context=target.typing_context, library=library,
        environment=environment, entry_point=entry, fndesc=description, signature=signature,
        type_annotation=annotation, objectmode=objectmode, lifted=lifted, reload_init=reload_init,
        referenced_envs=environments,
    )  # fmt: skip
