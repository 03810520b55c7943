"""The picture of the folders shows them as they are."""

import runpy
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"
DRAWN = runpy.run_path(str(DOCS / "draw_layers.py"))


def test_the_picture_of_the_folders_is_that_of_their_imports():
    kept = (DOCS / "layers.svg").read_text(encoding="utf-8")
    assert DRAWN["picture"]() == kept, "draw it anew: python docs/draw_layers.py"


def test_it_shows_every_folder_and_no_import_but_downwards():
    names = DRAWN["layers"]()
    own = DOCS.parent / "lumped"
    assert {p.name for p in own.iterdir() if (p / "__init__.py").exists()} <= set(names)
    for i, name in enumerate(names):
        assert DRAWN["imported"](name) <= set(names[i + 1 :]), name
