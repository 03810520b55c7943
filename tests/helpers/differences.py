"""Derivatives by central differences."""

_WEIGHTS = {2: (1 / 2,), 4: (8 / 12, -1 / 12), 6: (3 / 4, -3 / 20, 1 / 60)}


def slope(value, x, h, order=6):
    """Derivative of a function at a place, by steps of a size; the error falls with the order."""
    pairs = [(value(x + k * h), value(x - k * h)) for k in range(1, len(_WEIGHTS[order]) + 1)]
    return sum(
        weight * (above - below) / h
        for weight, (above, below) in zip(_WEIGHTS[order], pairs, strict=True)
    )
