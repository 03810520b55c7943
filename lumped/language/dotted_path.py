"""Dotted paths to parts, such as ``mass[3].J``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lumped.errors import UnknownNameError


def steps(path: str) -> list[str]:
    """Parts of a dotted path; dots inside ["..."] do not count."""
    found, current, depth = [], "", 0
    for letter in path:
        depth += (letter == "[") - (letter == "]")
        if letter == "." and depth == 0:
            found.append(current)
            current = ""
        else:
            current += letter
    return [*found, current] if path else []


def split_key(head: str) -> tuple[str, str | None]:
    """Name of a slot and the key of the member, if there is one."""
    if not head.endswith("]"):
        return head, None
    slot, _, key = head[:-1].partition("[")
    return slot, key.strip("\"'")


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
