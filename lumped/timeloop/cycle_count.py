"""Cycles of a recorded load, and the damage of given cycles, by the time loop's own count."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lumped.functionals.damage_law import DamageLaw
from lumped.kernel import engine
from lumped.kernel.cycles import FOUR, THREE, Count


@dataclass(frozen=True, eq=False)
class Counted:
    """Cycles of a load.

    Attributes
    ----------
    cycles : ndarray of int, shape (k, 2)
        Numbers of the values at which each begins and ends.
    weights : ndarray, shape (k,)
        1 for a cycle, 0.5 for half of one.
    turning : ndarray of int, shape (t,)
        Numbers of the values at which the load turns, with its first and last.
    residue : ndarray of int, shape (r,)
        Those of turning points that close no cycle; none where they count as half cycles.
    damage : float
        Sum of the damage of the cycles, one after the other.
    """

    cycles: np.ndarray
    weights: np.ndarray
    turning: np.ndarray
    residue: np.ndarray
    damage: float


def count_record(laws: Sequence[DamageLaw], depth: int) -> Count:
    """The record of counts of loads, one for each law.

    Parameters
    ----------
    depth : int
        Room for turning points of each that closed no cycle yet.
    """
    count = Count({"loads": len(laws), "depth": depth}, loads=len(laws), depth=depth)
    count.rule[:] = THREE
    count.scale[:] = [law.scale for law in laws]
    count.row[1:] = np.cumsum([len(law.rows) for law in laws])
    count.curve = np.array([row for law in laws for row in law.rows], dtype=float).ravel()
    count.extends_down[:] = [law.extends_down for law in laws]
    count.mean_stress[:] = [law.mean_stress.kind for law in laws]
    count.mean_number[:] = [law.mean_stress.number for law in laws]
    return count


def count_cycles(
    load: np.ndarray, law: DamageLaw | None = None, *, rule: Literal["three", "four"] = "three"
) -> Counted:
    """Rainflow count of a load, finite numbers of shape (n,).

    Parameters
    ----------
    law : DamageLaw, optional
        What a cycle does; nothing by default.
    rule : {"three", "four"}
        Points that a cycle is found from (see `lumped.kernel.cycles`).
    """
    values = np.ascontiguousarray(load, dtype=float)
    n = len(values)
    count = count_record([law or DamageLaw()], n)
    count.rule[:] = THREE if rule == "three" else FOUR
    count.values, count.notes = n, 1
    count.noted_cycle, count.noted_weight = np.zeros(2 * n, dtype=np.int64), np.zeros(n)
    count.turn = np.zeros(n, dtype=np.int64)
    engine.call("count_all", count, values)
    return Counted(
        count.noted_cycle.reshape(-1, 2)[: count.noted],
        count.noted_weight[: count.noted],
        count.turn[: count.turned],
        count.held_at[: int(count.size[0])],
        float(count.damage[0]),
    )


def damage_of_cycles(
    ranges: np.ndarray, means: np.ndarray, weights: np.ndarray, law: DamageLaw
) -> tuple[float, np.ndarray]:
    """Sum of the damage of cycles; of each, its damage and derivatives by range and mean, (k, 3).

    Parameters
    ----------
    ranges, means, weights : ndarray, shape (k,)
        In the unit of the load; 1 for a cycle, 0.5 for half of one.
    """
    cycles = np.ascontiguousarray(np.column_stack([ranges, means, weights]), dtype=float)
    found = np.zeros_like(cycles)
    count = count_record([law], 0)
    count.values = len(cycles)
    engine.call("sum_damage", count, cycles.ravel(), found.ravel())
    return float(count.damage[0]), found
