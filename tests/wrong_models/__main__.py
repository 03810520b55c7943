"""Write docs/errors.md: `python -m tests.wrong_models`."""

from .catalogue import CATALOGUE, catalogue

CATALOGUE.write_text(catalogue(), encoding="utf-8")
