"""Models of parts in a row."""

import lumped as lp


def in_a_row(**parts):
    """A model of these parts, each joined to the next one."""
    return lp.compose(
        **parts, connections=lambda m: lp.chain(*(getattr(m, name) for name in parts))
    )


def assemble_row(**parts):
    """Assemble a model of these parts, each joined to the next one."""
    return lp.assemble(in_a_row(**parts))
