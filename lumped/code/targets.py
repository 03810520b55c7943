"""Processors for which machine code is made before it is needed."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import llvmlite.binding as llvm

_X86_LEVELS = {
    "x86-64-v4": "avx512f avx512bw avx512cd avx512dq avx512vl",
    "x86-64-v3": "avx avx2 bmi bmi2 f16c fma lzcnt movbe",
    "x86-64-v2": "cx16 popcnt sahf sse3 sse4.1 sse4.2 ssse3",
}
"""Levels of the instruction set, from the highest; each adds to those below it."""


class Target(NamedTuple):
    """A platform, and the level of its instruction set."""

    triple: str
    level: str

    @property
    def name(self) -> str:
        """Architecture, system, and level; without the version of the system."""
        architecture, _, system = self.triple.split("-")[:3]
        return f"{architecture}-{system.rstrip('.0123456789')}-{self.level}"

    def machine(self) -> Any:
        """Emits its machine code."""
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
        return llvm.Target.from_triple(self.triple).create_target_machine(
            cpu=self.level, opt=2, jit=True
        )


RELEASED = (
    *(Target("x86_64-unknown-linux-gnu", level) for level in _X86_LEVELS),
    Target("aarch64-unknown-linux-gnu", "generic"),
)
"""Those of the wheel that is published."""


@cache
def find_own_target() -> Target | None:
    """That of this process; None for a processor below all levels."""
    triple = llvm.get_process_triple()
    if not triple.startswith("x86_64"):
        return Target(triple, "generic")
    features, found = llvm.get_host_cpu_features(), None
    for level, words in reversed(_X86_LEVELS.items()):
        if not all(features.get(word) for word in words.split()):
            break
        found = Target(triple, level)
    return found
