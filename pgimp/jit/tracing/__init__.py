"""Kernels to LLVM in one walk over their source, with all that types decide done on the way.

Numba compiles a function from bytecode: it infers types and emits instructions, for each function
that is inlined anew. Here types are known as the walk comes to them, functions are walked through
where they are called, and tuples exist only while tracing. `statements` begins above the others:
`calls`, `expressions` and `emitter`; `source` knows names and loops, `kernel` makes a kernel of it.
"""
