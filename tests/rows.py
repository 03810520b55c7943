"""Models of one part, and of parts in a row."""

import lumped as lp


def in_a_row(**parts):
    """A model of these parts, each joined to the next one."""
    return lp.compose(
        **parts, connections=lambda m: lp.chain(*(getattr(m, name) for name in parts))
    )


def assemble_row(**parts):
    """Assemble a model of these parts, each joined to the next one."""
    return lp.assemble(in_a_row(**parts))


def one(equations, **declared):
    """A component, called One, with these equations and what else is declared."""
    body = {"equations": equations, "__doc__": "See equations.", **declared}
    return type("One", (lp.Component,), body)()
