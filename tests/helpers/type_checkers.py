"""Mypy and Pyright on the files of `tests/typing`, run in a folder of a user of the package."""

import json
import os
import re
import shutil
from pathlib import Path

from processes import python

_FOLDER = Path(__file__).parents[1] / "typing"
FILES = sorted(set(_FOLDER.glob("*.py")) - set(_FOLDER.glob("test_*.py")))
_MARK = re.compile(r"# error: ([\w-]+), (\w+)$")
_MYPY = re.compile(r"(\w+\.py):(\d+): error: .*\[([\w-]+)\]$")

# Only what constructors need: all of lumped and pint take Mypy 20 s.
_NEEDED = ("components.*", "errors", "language.*", "ops", "support.*")
_NEEDED += ("ensembles", "ensembles.distributions", "ensembles.laws")
_SETTINGS = f"""
[mypy]
strict = true
cache_dir = {os.devnull}
[mypy-lumped.*,casadi.*,pint.*,scipy.*]
follow_imports = skip
[mypy-lumped,{",".join(f"lumped.{name}" for name in _NEEDED)}]
follow_imports = normal
"""

Errors = set[tuple[str, int, str]]
"""File, line and code of each."""


def marked(place: int) -> Errors:
    """Errors as marked in the files, with the codes of Mypy (place 0) or Pyright (place 1)."""
    lines = [
        (f.name, i, line) for f in FILES for i, line in enumerate(f.read_text().splitlines(), 1)
    ]
    found = [(name, i, _MARK.search(line)) for name, i, line in lines]
    return {(name, i, match.groups()[place]) for name, i, match in found if match}


def mypy(package: Path, folder: Path) -> Errors:
    """Errors that Mypy finds in copies of the files, with the package that stands in a folder."""
    (folder / "mypy.ini").write_text(_SETTINGS)
    lines = _run("mypy", package, folder, "--config-file", "mypy.ini").splitlines()
    matches = [_MYPY.match(line) for line in lines]
    assert all(match for match, line in zip(matches, lines, strict=True) if " error: " in line)
    return {(match[1], int(match[2]), match[3]) for match in matches if match}


def pyright(package: Path, folder: Path) -> Errors:
    """Errors that Pyright finds there."""
    (folder / "pyrightconfig.json").write_text('{"typeCheckingMode": "standard"}')
    answer = json.loads(_run("basedpyright", package, folder, "--outputjson"))
    return {
        (Path(one["file"]).name, one["range"]["start"]["line"] + 1, one["rule"])
        for one in answer["generalDiagnostics"]
        if one["severity"] == "error"
    }


def _run(checker: str, package: Path, folder: Path, *options: str) -> str:
    copies = [Path(shutil.copy(file, folder)).name for file in FILES]
    call = ("-m", checker, *options, *copies)
    return python(*call, cwd=folder, codes=(0, 1), PYTHONPATH=str(package))
