"""Inertias and shafts of a drive that is referred to one of its shafts."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class InertialPart:
    """An inertia of a drive.

    Attributes
    ----------
    name : str
        Path of the component.
    ratio : float
        Turns of its shaft for each turn of the reference shaft; negative for the other sense.
    J : float
        Moment of inertia on its own shaft, kg.m2.
    station : int
        Place in the referred drive; parts that are joined rigidly, by gears too, share one.
    """

    name: str
    ratio: float
    J: float
    station: int

    @property
    def referred(self) -> float:
        """Moment of inertia on the reference shaft, ``J ratio^2``, kg.m2."""
        return self.J * self.ratio**2


@dataclass(frozen=True)
class ElasticPart:
    """A stiffness of a drive.

    Attributes
    ----------
    name : str
        Path of the component.
    ratio : float
        Turns of the shaft for each turn of the reference shaft.
    c : float
        Stiffness on its own shaft, N.m/rad.
    stations : tuple of int
        What it joins; -1 stands for the ground.
    """

    name: str
    ratio: float
    c: float
    stations: tuple[int, int]

    @property
    def referred(self) -> float:
        """Stiffness on the reference shaft, ``c ratio^2``, N.m/rad."""
        return self.c * self.ratio**2


Part = InertialPart | ElasticPart
