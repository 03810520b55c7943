"""Adds the machine code of the time loop to a wheel; all else stands in pyproject.toml."""

import os
import shutil
import sys
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py


class BuildWithCode(build_py):
    """Compiles for this processor, or for all of a release if `LUMPED_TARGETS` is ``all``."""

    def run(self) -> None:
        """Copy the modules, and write machine code beside the copies."""
        super().run()
        if self.editable_mode:
            return
        sys.path.insert(0, str(Path(self.build_lib).resolve()))  # the modules that are installed
        sys.dont_write_bytecode = True
        from lumped.code import shipped, targets
        from lumped.kernel.engine import ASSEMBLY

        own = targets.find_own_target()
        released = os.environ.get("LUMPED_TARGETS") == "all"
        shutil.rmtree(shipped.FOLDER, ignore_errors=True)
        shipped.write_code(ASSEMBLY, targets.RELEASED if released else (own,) if own else ())


setup(cmdclass={"build_py": BuildWithCode})
