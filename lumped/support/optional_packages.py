"""Packages that only some functions of lumped need."""

from __future__ import annotations

import importlib
from typing import Any

from lumped.errors import OptionError


def extra(package: str, name: str, what: str) -> Any:
    """An optional package.

    Parameters
    ----------
    package : str
        Its name.
    name : str
        The extra of lumped that installs it.
    what : str
        The function that needs it, for the error.

    Raises
    ------
    OptionError
        If it is not installed.
    """
    try:
        return importlib.import_module(package)
    except ImportError:
        raise OptionError(f"{what} needs {package}: pip install lumped[{name}].") from None
