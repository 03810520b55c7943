#!/usr/bin/env -S uv run --script
# /// script
# dependencies = ["nox>=2025.2.9"]
# ///
"""Checks by name, each in an environment of its own: ``nox -s checks``, ``tests``, ``site``."""

import nox

nox.needs_version = ">=2025.2.9"
nox.options.default_venv_backend = "uv|virtualenv"


@nox.session
def checks(session: nox.Session) -> None:
    """Style, types, and direction of imports."""
    session.install("-e", ".[dev]")
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")
    session.run("mypy")
    session.run("lint-imports")


@nox.session
def tests(session: nox.Session) -> None:
    """Tests; arguments after ``--`` go to pytest."""
    session.install("-e", ".[test]")
    session.run("pytest", *session.posargs)


@nox.session(default=False)
def site(session: nox.Session) -> None:
    """The documentation."""
    session.install("-e", ".[docs]")
    session.run("sphinx-build", "-W", "docs", "site")


if __name__ == "__main__":
    nox.main()
