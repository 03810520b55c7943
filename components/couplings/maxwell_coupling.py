"""Elastic coupling whose damping is that of Maxwell branches."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from lumped import (
    Component,
    Connection,
    Equation,
    Expr,
    Flange,
    Param,
    Var,
    connect,
    der,
    param,
    var,
)
from lumped.components.couplings.elastic_coupling import _Coupling
from lumped.components.couplings.stiffness_table import Elasticity, from_stiffness
from lumped.errors import DeclarationError
from lumped.language.component import Made, path_of
from lumped.language.validity import Range
from lumped.language.value_types import Rows

if TYPE_CHECKING:
    from lumped.numerics.maxwell_fit import MaxwellFit

__all__ = ["MaxwellBranch", "MaxwellCoupling"]


class _Part(Component):
    """A torque between two flanges by the static law ``tau_s = F(static phi)``."""

    symbol = "spring_damper"
    flange_a = Flange()
    flange_b = Flange()
    stiffness: Rows = ()
    static: float = 1.0
    phi_rel: Var = var("rad", "twist", nominal=1e-4, state="prefer")
    tau: Var = var("N.m", "torque on flange b")

    def equations(self) -> Iterator[Equation]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau

    def dynamic(self, twist: Expr) -> Expr:
        """Dynamic stiffness at a static twist, N.m/rad."""
        return self._law().slope(self.static * twist)

    def torque(self, twist: Expr) -> Expr:
        """Static torque, N.m."""
        return self._law().torque(self.static * twist)

    def energy(self, twist: Expr) -> Expr:
        """Integral of the static torque, J."""
        return self._law().energy(self.static * twist) / self.static

    def highest(self) -> float:
        """Largest torque of the rows, N.m."""
        return self._law().highest

    def _law(self) -> Elasticity:
        return from_stiffness(self.stiffness)


class _StaticSpring(_Part):
    """Spring of a coupling in slow motion: ``tau = F(static phi_rel)``."""

    symbol = "spring"

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self.tau == self.torque(self.phi_rel)

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return self.energy(self.phi_rel)


class MaxwellBranch(_Part):
    """Spring and damper in series: ``tau = share / static (tau_s(phi_rel) - tau_s(phi_d))``.

    ``tau_s`` is the static law, and the twist of the damper follows by
    ``t_relax der(phi_d) == phi_rel - phi_d``. The energy of the spring,
    ``share / static (E(phi_rel) - E(phi_d) - tau_s(phi_d) (phi_rel - phi_d))`` with the integral E
    of ``tau_s``, and the heat ``share c(phi_d) (phi_rel - phi_d)^2 / t_relax`` are never negative,
    whatever the vibration. About a mean torque the complex stiffness is
    ``share c j w t_relax / (1 + j w t_relax)``.
    """

    share: Param = param("1", "stiffness of the spring over the dynamic one", above=0)
    t_relax: Param = param("s", "relaxation time", above=0)
    phi_d: Var = var("rad", "twist of the damper", nominal=1e-4, state="prefer")
    power: Var = var("W", "dissipated power")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self.t_relax * der(self.phi_d) == self.phi_rel - self.phi_d
        missing = self.torque(self.phi_rel) - self.torque(self.phi_d)
        yield self.tau == self.share / self.static * missing
        stretch = self.phi_rel - self.phi_d
        yield self.power == self.share * self.dynamic(self.phi_d) * stretch**2 / self.t_relax

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.power

    def stored(self) -> Expr:
        """Elastic energy, J."""
        stretch = self.phi_rel - self.phi_d
        most = self.energy(self.phi_rel) - self.energy(self.phi_d)
        return self.share / self.static * (most - self.torque(self.phi_d) * stretch)


def _spring(coupling: MaxwellCoupling) -> _StaticSpring:
    coupling.fit()
    return _StaticSpring(stiffness=coupling.stiffness, static=coupling.static)


def _branches(coupling: MaxwellCoupling) -> list[MaxwellBranch]:
    return [
        MaxwellBranch(
            stiffness=coupling.stiffness, static=coupling.static, share=share, t_relax=time
        )
        for share, time in coupling.fit().branches
    ]


class MaxwellCoupling(_Coupling):
    """Elastic coupling of a spring and Maxwell branches, the same in runs and responses.

    Static stiffness, dynamic stiffness and relative damping psi are those of a catalogue over a
    `band` of frequencies, in runs of any frequency content too; `ElasticCoupling` has them in a run
    at one frequency. `stiffness` are rows of mean torque and dynamic stiffness there, linear
    between; `static` is the static stiffness over it. In slow motion ``tau = F(static phi_rel)``,
    ``d F / d phi = c``. A vibration about a mean torque meets

        ``c (static + sum(share j w T / (1 + j w T)))``

    with a share and a relaxation time T for each of the `branches`, which are fitted so that this
    is ``c (1 + j psi / (2 pi))`` over the band (least squares, `fit` tells its errors; worse than
    20 % is refused). psi is the energy lost in a period over the elastic energy
    ``c' abs(twist)^2 / 2``, c' the real part. Outside the band psi falls.

    The law holds up to the last torque of the rows; beyond is an error, unless `extrapolate`
    continues the last stiffness. For a warm coupling give its warm stiffness and psi.

    Source: the generalised Maxwell model; definition of psi by DIN 740-2 (1986).
    """

    static: float = 0.7
    psi: float = 0.0
    band: tuple[float, float] = (0.0, 0.0)
    n_branches: int = 3
    spring: Any = Made(_spring)
    branches: Any = Made(_branches)

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self.c == self.spring.dynamic(self.spring.phi_rel)
        yield self.tau_c == self.spring.tau
        tau, power = self.spring.tau, 0.0
        for branch in self.branches:
            tau, power = tau + branch.tau, power + branch.power
        yield self.tau == tau
        yield self.power == power

    def connections(self) -> Iterator[Connection]:
        for part in (self.spring, *self.branches):
            yield connect(self.flange_a, part.flange_a)
            yield connect(self.flange_b, part.flange_b)

    def valid(self) -> Iterator[Range]:
        """Torques of the rows."""
        if not self.extrapolate:
            hint = "Give rows up to there, or extrapolate=True"
            most = self.spring.highest()
            yield Range(self.tau_c, -most, most, "N.m", "torque", hint)

    def fit(self) -> MaxwellFit:
        """Branches that meet the catalogue, and their errors.

        Raises
        ------
        DeclarationError
            If a number makes no sense, or an error exceeds 20 %.
        """
        from lumped.numerics.maxwell_fit import maxwell_fit

        try:
            return maxwell_fit(self.static, self.psi, self.band, self.n_branches)
        except DeclarationError as error:
            path = path_of(self)
            raise DeclarationError(f"{path} (MaxwellCoupling): {error}".lstrip()) from None
