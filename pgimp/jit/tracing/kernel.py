"""A kernel: from its source to machine code, with Numba's entry for Python."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from llvmlite import ir
from numba.core import compiler, funcdesc, types
from numba.core.lowering import Environment
from numba.core.targetconfig import ConfigStack
from numba.core.typing.templates import signature

from pgimp.jit.outside import NumbaObject
from pgimp.jit.tracing.entry import Entry, is_simple
from pgimp.jit.tracing.functions import arrays_of
from pgimp.jit.tracing.operations import AgainError
from pgimp.jit.tracing.statements import Tracer
from pgimp.jit.tracing.values import Argument, UntraceableError, running

#: Depth of Python's stack for functions in functions in functions.
_DEEPEST = 10_000


class _Description:
    """What a description of a function needs of Numba's form of it."""

    def __init__(self, function: NumbaObject) -> None:
        self.func_id, self.arg_names = function, function.arg_names


def compiled(state: NumbaObject) -> NumbaObject:
    """Compile a kernel, or a function that other compiled functions call.

    Parameters
    ----------
    state
        State of Numba's compiler: function, types of arguments, options, contexts, library.

    Returns
    -------
    numba.core.compiler.CompileResult

    Raises
    ------
    UntraceableError
        With notes on where.
    """
    widened: dict[tuple, NumbaObject] = {}
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(max(before, _DEEPEST))
    try:
        with ConfigStack().enter(state.flags.copy()):  # for what Numba compiles meanwhile
            while True:  # each turn widens a variable, of which there are not many
                with suppress(AgainError):
                    return _compiled(state, widened)
    finally:
        sys.setrecursionlimit(before)


def _compiled(state: NumbaObject, widened: dict) -> NumbaObject:
    function, kinds, target = state.func_id, tuple(state.args), state.targetctx
    flags, library = state.flags, state.library
    named = {f"arg.{n}": kind for n, kind in zip(function.arg_names, kinds, strict=True)}
    describe: Any = funcdesc.PythonFunctionDescriptor
    description = describe.from_specialized_function(
        _Description(function), named, types.none, {}, mangler=target.mangler,
        inline=flags.forceinline, noalias=False, abi_tags=[flags.get_mangle_string()],
    )  # fmt: skip
    environment = Environment.from_fndesc(description)
    # Instructions have their own flags: some functions are not contracted.
    context = target.subtarget(environment=environment, fndesc=description, fastmath=False)
    module = library.create_ir_module(description.unique_name)
    with target.push_code_library(library):
        context.declare_env_global(module, context.get_env_name(description))
        entry = context.declare_function(module, description)
        contracts = "contract" in (flags.fastmath.flags if flags.fastmath else ())
        tracer = Tracer(state.typingctx, context, module, widened)
        args = [running(kind, None) for kind in kinds]
        called = not flags.no_cpython_wrapper
        if called and not (flags.forceinline or flags.nrt) and is_simple(kinds):
            form = ir.FunctionType(entry.ftype.return_type, entry.ftype.args)
            lean = ir.Function(module, form, f"{entry.name}.lean")
            lean.attributes.add("noinline")
            value, taken = tracer.define(lean, function.func, contracts, args)
            if not all(isinstance(each, Argument) for each in arrays_of(value)):
                raise UntraceableError(f"{function.func_qualname} returns an array that it makes")
            _forward(entry, lean, taken)
        else:
            lean = None
            value, taken = tracer.define(entry, function.func, contracts, args, whole=True)
        description.restype = result = tracer.kind_of(value)
        context.post_lowering(module, library)
        library.add_ir_module(module)
        if lean is not None:
            wrapper = context.create_module("wrapper")
            callee = ir.Function(wrapper, lean.ftype, lean.name)
            used = [each.used for each in taken]
            Entry(context, wrapper, used, func=callee, fndesc=description, env=environment).build()
            library.add_ir_module(wrapper)
        elif called:
            context.create_cpython_wrapper(library, description, environment, None)
    code = target.get_executable(library, description, environment)
    target.insert_user_function(code, description, [library])
    return compiler.compile_result(
        target_context=target, typing_context=state.typingctx, library=library,
        environment=environment, entry_point=code, fndesc=description, type_annotation="",
        signature=signature(result, *kinds), objectmode=False, lifted=(), reload_init=[],
        referenced_envs=(),
    )  # fmt: skip


def _forward(entry: ir.Function, lean: ir.Function, arguments: Sequence[Argument]) -> None:
    """Have a kernel's function for all arguments call the one for those that it uses."""
    given, passed = iter(entry.args[2:]), [*entry.args[:2]]
    for each in arguments:
        parts = [next(given) for _ in each.parts]
        passed += parts if each.used else []
    entry.args[0].type = lean.args[0].type
    entry.ftype.args = tuple(each.type for each in entry.args)
    builder = ir.IRBuilder(entry.append_basic_block("entry"))
    builder.ret(builder.call(lean, passed))
