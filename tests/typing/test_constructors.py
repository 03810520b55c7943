"""Constructors are typed: type checkers refuse the marked lines and no others."""

from pathlib import Path

from type_checkers import marked, mypy, pyright

import lumped

ROOT = Path(lumped.__file__).parents[1]


def test_mypy_finds_exactly_the_marked_errors(tmp_path: Path) -> None:
    received = mypy(ROOT, tmp_path)
    expected = marked(0)
    assert received == expected
    assert len(expected) > 30


def test_pyright_finds_exactly_the_marked_errors(tmp_path: Path) -> None:
    received = pyright(ROOT, tmp_path)
    expected = marked(1)
    assert received == expected
