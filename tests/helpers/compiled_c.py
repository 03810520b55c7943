"""C of kernels in a library, as exported units compile it."""

import ctypes
import subprocess

from lumped.code.to_c import as_c


def compile_c(functions, folder):
    """A library of functions by their symbols."""
    (folder / "f.c").write_text(as_c(functions))
    options = ["-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Werror", "-Wno-unknown-pragmas"]
    command = ["cc", *options, "-Wno-unused-function", "-shared", "-fPIC", "f.c", "-o", "f.so"]
    subprocess.run([*command, "-lm"], cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "f.so"))
