"""Models that are wrong, a module for each kind of mistake, and the answers to them."""

from collections.abc import Callable
from dataclasses import dataclass

from lumped.errors import LumpedError


@dataclass(frozen=True)
class Case:
    """A mistake: its kind, what the user did, how, and what the answer must hold."""

    kind: str
    mistake: str
    name: str
    make: Callable[[], object]
    error: type[LumpedError]
    words: tuple[str, ...]


class Table:
    """The mistakes of one kind; called as a decorator, it enters one."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.cases: list[Case] = []

    def __call__(self, error: type[LumpedError], *words: str):
        """Enter a function into the table; its docstring says what the user did."""

        def enter(make):
            case = Case(self.kind, make.__doc__, make.__name__, make, error, words)
            self.cases.append(case)
            return make

        return enter
