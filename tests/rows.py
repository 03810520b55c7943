"""Models of one part, and of parts in rows."""

import itertools
import operator

import lumped as lp


def in_rows(*rows, **parts):
    """A model of these parts, of which those named in each row are joined one to the next.

    Of lists of parts, ``shaft/wheel``, one of each follows the other. A row of ports and signals,
    ``sensor.w control.measured``, joins them all.
    """

    def named(m, word):
        found = (operator.attrgetter(name)(m) for name in word.split("/"))
        lists = (part if isinstance(part, list | tuple) else [part] for part in found)
        return itertools.chain(*zip(*lists, strict=True))

    def connect(m):
        for row in rows:
            found = [part for word in row.split() for part in named(m, word)]
            yield from lp.chain(*found) if "." not in row else [lp.connect(*found)]

    return lp.compose(**parts, connections=connect)


def in_a_row(initial_equations=None, **parts):
    """A model of these parts, each joined to the next one."""
    return in_rows(" ".join(parts), **parts, initial_equations=initial_equations)


def assemble_rows(*rows, keep=(), **parts):
    """Assemble a model of these parts, joined in rows."""
    return lp.assemble(in_rows(*rows, **parts), keep=keep)


def assemble_row(keep=(), **parts):
    """Assemble a model of these parts, each joined to the next one."""
    return lp.assemble(in_a_row(**parts), keep=keep)


def in_turn(bodies, springs):
    """A model of bodies, each joined to the next one by one of the springs."""

    def connections(model):
        pairs = zip(model.bodies, model.springs, strict=False)
        yield from lp.chain(*(part for pair in pairs for part in pair), model.bodies[-1])

    return lp.compose(bodies=bodies, springs=springs, connections=connections)


def one(equations, **declared):
    """A component, called One, with these equations and what else is declared."""
    body = {"equations": equations, "__doc__": "See equations.", **declared}
    return type("One", (lp.Component,), body)()
