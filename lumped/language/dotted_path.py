"""Dotted paths to parts, such as ``mass[3].J``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from lumped.errors import UnknownNameError

_DOT = re.compile(r"\.(?![^\[]*\])")
"""Not before the end of a bracket."""


def steps(path: str) -> list[str]:
    """Parts of a dotted path; dots inside ["..."] do not count."""
    return _DOT.split(path) if path else []


def split_key(head: str) -> tuple[str, str | None]:
    """Name of a slot and the key of the member, if there is one."""
    if not head.endswith("]"):
        return head, None
    slot, _, key = head[:-1].partition("[")
    return slot, key.strip("\"'")


def list_members(slot: str, held: Any) -> list[tuple[str, Any]]:
    """Places of the parts of a slot, such as ``mass[3]``, and the parts."""
    if isinstance(held, Mapping):
        return [(f'{slot}["{key}"]', part) for key, part in held.items()]
    if isinstance(held, list | tuple):
        return [(f"{slot}[{i}]", part) for i, part in enumerate(held)]
    return [(slot, held)]


def find_member(held: Any, key: str | None, slot: str) -> Any:
    """The part that a key names among those of a slot."""
    if not isinstance(held, Mapping | list | tuple):
        if key is not None:
            raise UnknownNameError(f"'{slot}' is one part; write {slot} without [{key}].")
        return held
    members = held if isinstance(held, Mapping) else {str(i): p for i, p in enumerate(held)}
    if key is None or key not in members:
        what = "holds several parts" if key is None else f"has no member [{key}]"
        raise UnknownNameError(f"'{slot}' {what}. Known: {', '.join(f'[{k}]' for k in members)}.")
    return members[key]


def replace_member(held: Any, key: str | None, value: Any) -> Any:
    """Parts of a slot with one of them replaced; the slot has only one without a key."""
    if key is None:
        return value
    if isinstance(held, Mapping):
        return {**held, key: value}
    members = list(held)
    members[int(key)] = value
    return members
