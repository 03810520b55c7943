"""A folder reads no private name of another."""

import ast
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2] / "lumped"
NAMED_TUPLE = {"_replace", "_asdict", "_fields"}


def private(name: str) -> bool:
    return name.startswith("_") and not name.endswith("__") and name not in NAMED_TUPLE


def defined(tree: ast.AST) -> set[str]:
    """Private names that a module gives to its functions, classes and their attributes."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            found.add(node.attr)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.add(node.value)  # object.__setattr__(made, "_values", values)
    return found


def test_a_folder_reads_no_private_name_of_another():
    own, read = defaultdict(set), defaultdict(list)
    for file in ROOT.rglob("*.py"):
        folder, tree = file.relative_to(ROOT).parts[0], ast.parse(file.read_text("utf-8"))
        own[folder] |= defined(tree)
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute) and private(node.attr):
                read[folder, node.attr].append(f"{file.relative_to(ROOT)}:{node.lineno}")
            if isinstance(node, ast.ImportFrom) and node.module != "__future__":
                for alias in node.names:
                    if private(alias.name):
                        read[folder, alias.name].append(f"{file.relative_to(ROOT)}:{node.lineno}")
    assert len(read) > 300
    strange = {k: places for k, places in read.items() if k[1] not in own[k[0]]}
    assert not strange, strange
