"""The ``lumped`` command."""

from lumped import __version__


def main() -> int:
    """Print the version."""
    print(f"lumped {__version__}")
    return 0
