"""The small language of the time loop, and its back ends: LLVM, C, Python itself."""
