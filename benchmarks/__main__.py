"""Run all benchmarks, or those named, and write what they found where readers look.

    python -m benchmarks [name ...]

Each script writes its tables to ``results`` as CSV; this one sets them in ``results/README.md``,
with the machine and the versions, the most telling numbers in ``docs/benchmarks.md`` and
``docs/published.md``, and three rows in the README.
"""

import csv
import importlib
import importlib.metadata
import os
import pkgutil
import platform
import sys
import time
from pathlib import Path

import benchmarks
from benchmarks.harness import RESULTS
from benchmarks.report import front_page, published_page, summary

VERSIONS = ("casadi", "numpy", "scipy", "llvmlite")


def scripts() -> dict[str, str]:
    """Names of the benchmarks and their questions."""
    found = {}
    for info in pkgutil.iter_modules(benchmarks.__path__):
        if not info.name.startswith("_"):
            module = importlib.import_module(f"benchmarks.{info.name}")
            if hasattr(module, "main"):
                found[info.name] = (module.__doc__ or "").strip().splitlines()[0]
    return found


def machine() -> str:
    """Machine and versions in one line."""
    versions = []
    for name in VERSIONS:
        try:
            versions.append(f"{name} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            versions.append(f"no {name}")
    cores = f"{os.cpu_count()} cores {platform.machine()}"
    return (
        f"{platform.system()}, {cores}, Python {platform.python_version()}, {', '.join(versions)}"
    )


def as_markdown(path: Path) -> str:
    """A table of results as it stands in its file."""
    with path.open(newline="") as file:
        head, *rows = csv.reader(file)
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell or " " for cell in line) + " |" for line in lines)


def write_page(questions: dict[str, str]) -> None:
    """All tables, each under the question that it answers."""
    parts = ["# What the benchmarks found", machine()]
    for name, question in questions.items():
        tables = sorted(RESULTS.glob(f"{name.removesuffix('_time')}*.csv"))
        if tables:
            parts.append(f"## {question}\n\n`python -m benchmarks.{name}`")
            parts += [as_markdown(path) for path in tables]
    (RESULTS / "README.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def main(wanted: list[str]) -> None:
    """Run what is wanted, one after the other."""
    questions = scripts()
    unknown = set(wanted) - questions.keys()
    if unknown:
        sys.exit(f"no benchmark {', '.join(sorted(unknown))}; there are {', '.join(questions)}")
    for name in wanted or questions:
        print(f"\n== {questions[name]}", flush=True)
        begin = time.perf_counter()
        sys.argv = [name]
        importlib.import_module(f"benchmarks.{name}").main()
        print(f"({time.perf_counter() - begin:.0f} s)", flush=True)
    write_page(questions)
    root = Path(__file__).parents[1]
    summary.write(root / "docs" / "benchmarks.md")
    published_page.write(root / "docs" / "published.md")
    front_page.write(root / "README.md")


if __name__ == "__main__":
    main(sys.argv[1:])
