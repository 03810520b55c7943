"""Ports: where components meet. Potentials are equal, flows sum to zero."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Literal, Never, Self

from lumped.errors import EquationError, UnknownNameError
from lumped.language.expression import Call, Der, Equation, Expr, Partial, Ref, walk
from lumped.language.quantity import Quantity
from lumped.support.arguments import checked


class PortQuantity(Quantity):
    """Potential or flow of a port.

    Parameters
    ----------
    unit, text : str
        SI unit and meaning.
    kind : {"potential", "flow"}
        Which of both it is: equal where ports meet, or with a sum of zero.
    """

    def __init__(self, unit: str, text: str, kind: Literal["potential", "flow"]) -> None:
        super().__init__(unit, text)
        self.kind = kind


class Port:
    """A port of a component: declared in the class body, bound to an instance on access.

    Parameters
    ----------
    free : bool
        The port may stay unconnected; its flow is then zero (a free shaft end).
    grounded : bool
        The port may stay unconnected; its potential is then zero (a housing bolted down).
    """

    kind: ClassVar[str]
    potential: ClassVar[Quantity]
    potential_name: ClassVar[str]
    flow: ClassVar[Quantity]
    flow_name: ClassVar[str]

    @checked
    def __init__(self, *, free: bool = False, grounded: bool = False) -> None:
        self.free = free
        self.grounded = grounded
        self.name = ""
        self.owner: Any = None

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, obj: Any, owner: type) -> Self:
        if obj is None:
            return self
        bound = object.__new__(type(self))
        bound.__dict__.update(self.__dict__, owner=obj)
        return bound

    if TYPE_CHECKING:  # refused as an argument of the component's constructor

        def __set__(self, obj: Never, value: Never) -> None: ...

    else:  # type checkers shall go on finding misspelt names

        def __getattr__(self, name: str) -> Any:
            if name.startswith("_"):
                raise AttributeError(name)
            kind = "" if self.owner is None else f"{type(self.owner).__name__}."
            raise UnknownNameError(
                f"{kind}{self.name} ({self.kind}) has no '{name}'; it has {self.potential_name} "
                f"and {self.flow_name}. A rate is der({self.name}.{self.potential_name})."
            )

    def across(self) -> Ref:
        """The potential."""
        return Ref(self.owner, f"{self.name}.{self.potential_name}", self.potential)

    def through(self) -> Ref:
        """The flow into the component."""
        return Ref(self.owner, f"{self.name}.{self.flow_name}", self.flow)

    def __repr__(self) -> str:
        return f"{self.kind} {self.name}"


class Flange(Port):
    """End of a shaft: angle `phi` in rad, torque `tau` in N.m acting on the component."""

    kind = "rotational flange"
    potential = PortQuantity("rad", "angle of the flange", "potential")
    potential_name = "phi"
    flow = PortQuantity("N.m", "torque on the component", "flow")
    flow_name = "tau"

    @property
    def phi(self) -> Ref:
        """Angle, rad."""
        return self.across()

    @property
    def tau(self) -> Ref:
        """Torque acting on the component, N.m."""
        return self.through()


class LinearFlange(Port):
    """End of a rod: position `s` in m, force `f` in N acting on the component."""

    kind = "translational flange"
    potential = PortQuantity("m", "position of the flange", "potential")
    potential_name = "s"
    flow = PortQuantity("N", "force on the component", "flow")
    flow_name = "f"

    @property
    def s(self) -> Ref:
        """Position, m."""
        return self.across()

    @property
    def f(self) -> Ref:
        """Force acting on the component, N."""
        return self.through()


class Pin(Port):
    """Electrical pin: potential `v` in V, current `i` in A into the component."""

    kind = "electrical pin"
    potential = PortQuantity("V", "potential of the pin", "potential")
    potential_name = "v"
    flow = PortQuantity("A", "current into the component", "flow")
    flow_name = "i"

    @property
    def v(self) -> Ref:
        """Potential, V."""
        return self.across()

    @property
    def i(self) -> Ref:
        """Current into the component, A."""
        return self.through()


class HeatPort(Port):
    """Thermal port: absolute temperature `T` in K, heat flow `Q` in W into the component."""

    kind = "thermal port"
    potential = PortQuantity("K", "temperature of the port", "potential")
    potential_name = "T"
    flow = PortQuantity("W", "heat flow into the component", "flow")
    flow_name = "Q"

    @property
    def T(self) -> Ref:  # noqa: N802 - the letter of the formulas
        """Temperature, K."""
        return self.across()

    @property
    def Q(self) -> Ref:  # noqa: N802
        """Heat flow into the component, W."""
        return self.through()


@checked
def lossless(relation: Equation, *ports: Port) -> tuple[Equation, ...]:
    """Equations of a part without stiffness, inertia and loss, from its kinematics alone.

    The kinematic relation fixes one port's potential by those of the others; the flows follow
    from virtual work: if ``q_0 == g(q_1, ..., q_n)``, then ``flow_i == -dg/dq_i * flow_0``
    (Lanczos, The Variational Principles of Mechanics, ch. III). If rates are related,
    ``der(q_0) == sum(a_i der(q_i))``, then ``flow_i == -a_i * flow_0``, whether or not there is a
    function of the potentials with these derivatives.

    Parameters
    ----------
    relation : Equation
        Potential of one of the ports ``==`` a function of the potentials of the others, or its
        rate ``==`` a sum of their rates times factors.
    *ports : Port
        All ports that take part.

    Returns
    -------
    tuple of Equation
        The relation and one flow equation for each port but the first-named of the relation.

    Raises
    ------
    EquationError
        If the left side is not the potential of one of the ports or its rate, or occurs on the
        right too, or rates are not in a sum.
    """
    known = {(id(p.owner), p.across().name): p for p in ports}
    of_rates = isinstance(relation.left, Der)
    left = relation.left.of if isinstance(relation.left, Der) else relation.left
    explicit = known.get((id(left.owner), left.name)) if isinstance(left, Ref) else None
    if explicit is None:
        raise EquationError(
            f"lossless('{relation!r}', ...): the left side must be the potential of one of the "
            f"ports {', '.join(p.name for p in ports)}, or its rate."
        )
    factors = (_rate_factors if of_rates else _slopes)(relation.right, set(known))
    if factors is None:
        raise EquationError(
            f"lossless('{relation!r}', ...): where the left side is a rate, the right side must be "
            "a sum of rates times factors, such as i * der(b.phi) + j * der(c.phi)."
        )
    if (id(explicit.owner), explicit.across().name) in factors:
        raise EquationError(f"lossless('{relation!r}', ...): {left!r} stands on both sides.")
    drive = explicit.through()
    flows = []
    for key, port in known.items():
        if port is not explicit:
            flows.append(port.through() == -factors.get(key, 0.0) * drive)
    return (relation, *flows)


def _slopes(of: Expr, known: set[_Key]) -> dict[_Key, Expr]:
    """Partial derivatives of an expression by the potentials in it."""
    used: dict[_Key, Ref] = {}
    for node in walk(of):
        if isinstance(node, Ref) and (id(node.owner), node.name) in known:
            used.setdefault((id(node.owner), node.name), node)
    return {key: Partial(of, node) for key, node in used.items()}


def _rate_factors(of: Expr, known: set[_Key]) -> dict[_Key, Expr] | None:
    """Factors of the rates of the potentials in a sum; None if it is none."""
    if isinstance(of, Der):
        return _slopes(of.of, known)
    if not any(isinstance(node, Der) and _slopes(node.of, known) for node in walk(of)):
        return {}
    if not isinstance(of, Call):
        return None
    parts = [_rate_factors(part, known) for part in of.args]
    match of.op, of.args, parts:
        case "neg", _, [{} as a]:
            return {key: -factor for key, factor in a.items()}
        case (("+" | "-"), _, [{} as a, {} as b]):
            found = dict(a)
            for key, factor in b.items():
                more = factor if of.op == "+" else -factor
                found[key] = found[key] + more if key in found else more
            return found
        case "*", (_, y), [{} as a, b] if b == {}:
            return {key: factor * y for key, factor in a.items()}
        case "*", (x, _), [a, {} as b] if a == {}:
            return {key: x * factor for key, factor in b.items()}
        case "/", (_, y), [{} as a, b] if b == {}:
            return {key: factor / y for key, factor in a.items()}
    return None


_Key = tuple[int, str]
"""Owner and name of a potential."""


class Connection:
    """Ports or signals that meet.

    Attributes
    ----------
    ends : tuple of Port or reference
        In the order given.
    """

    __slots__ = ("ends",)

    def __init__(self, ends: tuple[Port | Ref, ...]) -> None:
        self.ends = ends
