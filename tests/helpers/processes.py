"""Python in a process of its own."""

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def python(*arguments: str | Path, cwd: Path = ROOT, codes=(0,), **variables: str) -> str:
    """What Python prints; the checkout is found unless a variable says otherwise."""
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=cwd,
        env=os.environ | {"PYTHONPATH": str(ROOT)} | variables,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode in codes, done.stdout + done.stderr
    return done.stdout


def loaded(code: str) -> set[str]:
    """Modules that a script loads."""
    last = "print(json.dumps([*sys.modules]))"
    return set(json.loads(python("-c", f"import json, sys\n{code}\n{last}")))
