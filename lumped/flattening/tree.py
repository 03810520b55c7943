"""The component tree of a model: who is where, and the number of every quantity."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from operator import attrgetter

from lumped.errors import DeclarationError, UnknownNameError, nearest
from lumped.flattening.massless import Massless, without_inertia
from lumped.language.component import Component
from lumped.language.connection import label
from lumped.language.declared import (
    origins_of,
    parts_of,
    place_of,
    ports_of,
    quantities_of,
    values_of,
)
from lumped.language.dotted_path import steps
from lumped.language.expression import Expr, Ref
from lumped.language.formula import Formula
from lumped.language.port import Port
from lumped.language.quantity import Input, Output, Param, Quantity, Var
from lumped.language.validity import Range, check_ranges


class Layout:
    """Names of the unknowns and parameters of a component class, in fixed order.

    Attributes
    ----------
    unknowns : dict of str to int
        Local number of each unknown: port potentials and flows, signals, variables.
    quantities : list of Quantity
        Their declarations.
    inputs, outputs, variables : dict of str to int
        Those of the unknowns that are inputs, outputs, and variables proper.
    parameters : dict of str to int
        Local number of each parameter.
    """

    def __init__(self, cls: type[Component], massless: Massless | None = None) -> None:
        names: list[tuple[str, Quantity]] = []
        for name, port in ports_of(cls).items():
            names.append((f"{name}.{port.potential_name}", port.potential))
            names.append((f"{name}.{port.flow_name}", port.flow))
        names += [(n, q) for n, q in quantities_of(cls).items() if not isinstance(q, Param)]
        if massless is not None:
            names = [(n, massless.declared(n, q)) for n, q in names]
            names += massless.variables.items()
        self.unknowns = {name: i for i, (name, _) in enumerate(names)}
        self.names = [name for name, _ in names]
        self.quantities = [quantity for _, quantity in names]
        self.inputs, self.outputs, self.variables = (
            {n: i for i, (n, q) in enumerate(names) if isinstance(q, kind)}
            for kind in (Input, Output, Var)
        )
        self.ports = list(ports_of(cls))
        self.declared: dict[str, Param] = {
            n: q for n, q in quantities_of(cls).items() if isinstance(q, Param)
        }
        self.parameters = {name: i for i, name in enumerate(self.declared)}


@dataclass(eq=False)
class Instance:
    """One component of a model.

    Attributes
    ----------
    component : Component
        The instance.
    path : str
        Dotted path below the model; "" for the model itself.
    parent : int
        Number of the parent node, -1 for the model.
    first_unknown, first_parameter, first_port : int
        Number of its first unknown, parameter and port.
    massless : Massless, optional
        Its equations, if its friction slides beside springs only.
    children : dict of str to int
        Node number of each part.
    """

    component: Component
    path: str
    parent: int
    layout: Layout
    first_unknown: int
    first_parameter: int
    first_port: int
    massless: Massless | None = None
    children: dict[str, int] = field(default_factory=dict)

    def name(self, local: str) -> str:
        """Dotted name of a quantity of this component."""
        return f"{self.path}.{local}" if self.path else local

    def ranges(self) -> Iterator[Range]:
        """Where its equations hold."""
        yield from check_ranges(self.component.valid())
        yield from () if self.massless is None else self.massless.ranges

    @property
    def label(self) -> str:
        """How texts call the component."""
        kind = type(self.component).__name__
        return f"{self.path} ({kind})" if self.path else kind


class Tree:
    """All components of a model in declaration order, parents before parts.

    Parameters
    ----------
    model : Component
        The top of the tree.
    freed : frozenset of str
        Inputs that are unknowns though they are given.
    massless : mapping of str to bool, optional
        Paths of components whose friction slides beside springs only, and whether these are damped.

    Raises
    ------
    DeclarationError
        If the model itself has a quantity or parameter called ``time``.

    Attributes
    ----------
    instances : list of Instance
        The components.
    quantities : list of Quantity
        Declarations of the unknowns.
    input_parameters : dict of str to int
        Number of the parameter that each input given as a number became.
    """

    def __init__(
        self,
        model: Component,
        freed: frozenset[str] = frozenset(),
        massless: Mapping[str, bool] | None = None,
    ) -> None:
        self.model, self.freed, self.massless = model, freed, dict(massless or {})
        self.instances: list[Instance] = []
        self.quantities: list[Quantity] = []
        parameter_count = port_count = 0
        layouts: dict[type[Component], Layout] = {}
        self._number: dict[int, int] = {}
        self._origins: dict[int, dict[int, str]] = {}
        self.input_parameters: dict[str, int] = {}
        self._asked: dict[str, tuple[Instance, str]] = {}
        stack: list[tuple[Component, str, int, str]] = [(model, "", -1, "")]
        while stack:
            component, path, parent, own_name = stack.pop()
            number = len(self.instances)
            self._number[id(component)] = number
            cls = type(component)
            own = None
            if path in self.massless:
                items = component.equations()
                own = without_inertia(items, damped=self.massless[path])
                layout = Layout(cls, own)
            elif cls in layouts:
                layout = layouts[cls]
            else:
                layout = layouts[cls] = Layout(cls)
            firsts = self.unknown_count, parameter_count, port_count
            self.instances.append(Instance(component, path, parent, layout, *firsts, own))
            self.quantities += layout.quantities
            parameter_count += len(layout.parameters)
            port_count += len(layout.ports)
            if parent >= 0:
                self.instances[parent].children[own_name] = number
            parts = [
                (part, f"{path}.{name}" if path else name, number, name)
                for name, part in parts_of(component)
            ]
            stack.extend(reversed(parts))
        self._refuse_time()

    @property
    def unknown_count(self) -> int:
        """Number of unknowns."""
        return len(self.quantities)

    def _refuse_time(self) -> None:
        """Refuse a quantity or parameter of the model itself that has the name of the time."""
        top = self.instances[0]
        own = {"quantity": top.layout.unknowns, "parameter": top.layout.parameters}
        for what, names in own.items():
            if "time" in names:
                raise DeclarationError(
                    f"{top.label}: a {what} of the model itself cannot be called 'time', which is "
                    "the time in results, files and tables. Rename it; a quantity of a part may "
                    "have this name."
                )

    def find(self, component: Component, scope: Instance) -> Instance | None:
        """Node of a component named inside `scope`, or None if it is not a part of it.

        Both the part itself and the object it was made from (as used in `compose`) are known.
        """
        number = self._number.get(id(component))
        if number is not None:
            return self.instances[number]
        places = self._origins.get(id(scope.component))
        if places is None:
            places = self._origins[id(scope.component)] = origins_of(scope.component)
        names: list[str] = []
        current = component
        while True:
            origin = places.get(id(current))
            if origin is not None:
                names.append(origin)
                break
            place = place_of(current)
            if place is None:
                return None
            current, name = place
            names.append(name)
        node = scope
        for name in reversed(names):
            node = self.instances[node.children[name]]
        return node

    def below(self, component: Component, scope: Instance) -> str | None:
        """Path of a component relative to `scope`: "" for itself, None if it is not a part."""
        node = self.find(component, scope)
        if node is None or not (node is scope or node.path.startswith(scope.name(""))):
            return None
        return node.path[len(scope.path) :].lstrip(".")

    def at(self, path: str, scope: Instance) -> Instance:
        """Node at a path relative to `scope`."""
        node = scope
        for name in steps(path):
            node = self.instances[node.children[name]]
        return node

    def unknown(self, name: str | Expr) -> int:
        """Number of an unknown.

        Raises
        ------
        UnknownNameError
            If the model has no such unknown; the text lists the nearest names.
        """
        key = key_of(name)
        found = self._look_up(key)
        if found is not None:
            node, local = found
            if local in node.layout.unknowns:
                return node.first_unknown + node.layout.unknowns[local]
            raise UnknownNameError(f"'{key}' is a parameter, not an unknown of the model.")
        raise UnknownNameError(
            f"{type(self.model).__name__} has no quantity '{key}'. "
            + nearest(key, self.unknown_names())
        )

    def parameter(self, name: str | Expr) -> int:
        """Number of a parameter.

        Raises
        ------
        UnknownNameError
            If the model has no such parameter; the text lists the nearest names.
        """
        key = key_of(name)
        if key in self.input_parameters:
            return self.input_parameters[key]
        found = self._look_up(key)
        if found is not None:
            node, local = found
            if local in node.layout.parameters:
                return node.first_parameter + node.layout.parameters[local]
            raise UnknownNameError(f"'{key}' is no parameter{_why_none(node, local)}")
        raise UnknownNameError(
            f"{type(self.model).__name__} has no parameter '{key}'. "
            + nearest(key, self.parameter_names())
        )

    def computable(self, name: str | Expr) -> str:
        """The key of a quantity or formula; a parameter alone is a formula."""
        key = key_of(name)
        found = None if isinstance(key, Formula) else self._look_up(key)
        if found is None or found[1] not in found[0].layout.parameters:
            return key
        return Formula.made(lambda parameter: parameter, key)

    def reference(self, name: str) -> Ref:
        """Reference to an unknown or a parameter.

        Raises
        ------
        UnknownNameError
            If the model has neither of this name; the text lists the nearest names.
        """
        found = self._look_up(name)
        if found is not None:
            node, local = found
            place = node.layout.unknowns.get(local)
            own = node.layout.declared[local] if place is None else node.layout.quantities[place]
            return Ref(node.component, local, own)
        raise UnknownNameError(
            f"{type(self.model).__name__} has no quantity or parameter '{name}'. "
            + nearest(name, [*self.unknown_names(), *self.parameter_names()])
        )

    def _look_up(self, key: str) -> tuple[Instance, str] | None:
        if key in self._asked:
            return self._asked[key]
        node = self.instances[0]
        found = steps(key)
        for i, step in enumerate(found):
            if step in node.children:
                node = self.instances[node.children[step]]
                continue
            local = ".".join(found[i:])
            if local in node.layout.unknowns or local in node.layout.parameters:
                self._asked[key] = node, local
            break
        return self._asked.get(key)

    def unknown_names(self) -> Iterator[str]:
        """Names of all unknowns."""
        for node in self.instances:
            for local in node.layout.names:
                yield node.name(local)

    def parameter_names(self) -> Iterator[str]:
        """Names of all parameters."""
        for node in self.instances:
            for local in node.layout.parameters:
                yield node.name(local)
        yield from self.input_parameters

    def node_of_unknown(self, number: int) -> Instance:
        """Component that declares an unknown."""
        return self.instances[self.number_of_unknown(number)]

    def number_of_unknown(self, number: int) -> int:
        """Number of the component that declares an unknown."""
        return bisect_right(self.instances, number, key=attrgetter("first_unknown")) - 1

    def unknown_name(self, number: int) -> str:
        """Dotted name of an unknown."""
        node = self.node_of_unknown(number)
        return node.name(node.layout.names[number - node.first_unknown])

    def quantity(self, number: int) -> Quantity:
        """Declaration of an unknown."""
        return self.quantities[number]

    def port_name(self, node: Instance, port: int) -> str:
        """Dotted name of a port of a node."""
        return node.name(node.layout.ports[port])

    def port(self, node: Instance, port: int) -> Port:
        """Declaration of a port of a node."""
        return ports_of(node.component)[node.layout.ports[port]]


def _why_none(node: Instance, local: str) -> str:
    """Why an unknown is no parameter, and what could be named instead."""
    if node.layout.quantities[node.layout.unknowns[local]].kind != "input":
        return ": the model computes it. Name a parameter."
    if local in values_of(node.component):
        return (
            f", as it is given as the expression {values_of(node.component)[local]!r}. Name a "
            "parameter of the expression, or give a number instead of it."
        )
    return ", as it is connected to a signal. Name a parameter of what gives the signal."


def key_of(name: str | Expr) -> str:
    """Dotted name of what is meant by a name or a reference; the formula of an expression.

    Raises
    ------
    UnknownNameError
        If it is none of these.
    """
    if isinstance(name, str):
        return name
    if isinstance(name, Ref):
        return label(name)
    if isinstance(name, Expr):
        return Formula.of(name)
    raise UnknownNameError(
        f"{name!r} is neither a name nor a reference to a quantity; give one of these. "
        "run[[...]] takes a list of several."
    )
