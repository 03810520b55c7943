"""What a user without optional packages has."""

import builtins

import pytest

from lumped.support.display_units import _factors
from lumped.support.units import _registry


@pytest.fixture
def without_pint(monkeypatch):
    """No package for units, until it is undone."""
    real = builtins.__import__

    def without(name, *rest):
        if name == "pint":
            raise ImportError
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    _registry.cache_clear()
    _factors.cache_clear()
    return monkeypatch
