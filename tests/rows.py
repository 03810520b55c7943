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


def in_turn(bodies, springs):
    """A model of bodies, each joined to the next one by one of the springs."""

    def connections(model):
        pairs = zip(model.bodies, model.springs, strict=False)
        yield from lp.chain(*(part for pair in pairs for part in pair), model.bodies[-1])

    return lp.compose(bodies=bodies, springs=springs, connections=connections)
