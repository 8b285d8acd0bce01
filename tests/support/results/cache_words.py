"""What a run says of the kernel cache."""

COMPILING = "compiling for this kind of scene, once; this takes half a minute to some minutes"
