"""Models of one part, and of parts in rows."""

import itertools
import operator

import lumped as lp


def in_rows(*rows, **parts):
    """A model of these parts, of which those named in each row are joined one to the next.

    A row may name ports instead of parts, ``battery.n ground.pin``, or signals alone,
    ``sensor.w control.u``. Of lists of parts, ``shaft/wheel``, one of each follows the other.
    """

    def named(m, word):
        found = (operator.attrgetter(name)(m) for name in word.split("/"))
        lists = (part if isinstance(part, list | tuple) else [part] for part in found)
        return itertools.chain(*zip(*lists, strict=True))

    def connect(m):
        for row in rows:
            ends = [end for word in row.split() for end in named(m, word)]
            if isinstance(ends[0], lp.Component | lp.Port):
                yield from lp.chain(*ends)
            else:
                yield lp.connect(*ends)

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


def one(equations, **declared):
    """A component, called One, with these equations and what else is declared."""
    body = {"equations": equations, "__doc__": "See equations.", **declared}
    return type("One", (lp.Component,), body)()


def assemble_one(equations, keep=(), **declared):
    """Assemble a component with these equations and what else is declared."""
    return lp.assemble(one(equations, **declared), keep=keep)
