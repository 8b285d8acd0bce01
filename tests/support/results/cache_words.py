"""What a run says of the kernel cache."""

COMPILING = "compiling for this kind of scene, once; this takes ten seconds to a minute"
