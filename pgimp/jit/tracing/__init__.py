"""Kernels to LLVM in one walk over their source, with all that types decide done on the way."""
