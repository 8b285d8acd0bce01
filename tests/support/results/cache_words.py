"""What a run says of the kernel cache."""

COMPILING = "compiling for this kind of scene, once, about half a minute"
