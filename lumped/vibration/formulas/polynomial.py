"""Characteristic polynomials, with named parts, and their roots in closed form."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

from lumped.vibration.formulas.determinant import Entries, determinant, find_way, is_forest
from lumped.vibration.formulas.names import Names
from lumped.vibration.formulas.to_sympy import load_sympy, shortest

_EXPANDED = 330
"""Characters up to which a polynomial is written by its coefficients."""
_DAMPED = 2
"""Twists up to which a polynomial with damping is written by its coefficients."""


def second_order_entries(H: Any, G: Any, s: Any, names: Names, *, alone: bool) -> Entries:
    """Entries of ``s^2 I + H s + G``, named; of ``lambda I - G`` if `s` is lambda and H is None.

    In a drive without circles entries count only by the products of two that face each other,
    which are named in their place if `alone`, as nothing else is in the determinant.
    """
    n, found = G.rows, dict[tuple[int, int], Any]()
    raw: Entries = {}
    for i in range(n):
        for j in range(n):
            value = -G[i, j] if H is None else G[i, j] + s * H[i, j]
            if value != 0 or i == j:
                raw[i, j] = value
    products, is_long = alone and is_forest(raw, n), n > _DAMPED
    for (i, j), value in raw.items():
        if i == j:
            a = names.new("a", shortest(G[i, i]))
            if H is None:
                found[i, i] = s - a
            else:
                found[i, i] = s**2 + names.new("b", shortest(H[i, i])) * s + a
        elif not products:
            found[i, j] = _polynomial(value, s, names, "h", is_long)
        elif i < j:
            found[i, j] = -_polynomial(value * raw[j, i], s, names, "g", is_long)
            found[j, i] = load_sympy().Integer(-1)
    return found


def first_order_entries(A: Any, s: Any, names: Names, *, alone: bool) -> Entries:
    """Entries of ``s I - A``, named as those of `second_order_entries`."""
    n = A.rows
    raw = {(i, j): -A[i, j] for i in range(n) for j in range(n) if i == j or A[i, j] != 0}
    products, found = alone and is_forest(raw, n), dict[tuple[int, int], Any]()
    for (i, j), value in raw.items():
        if i == j:
            found[i, i] = s + names.new("a", shortest(value))
        elif not products:
            found[i, j] = names.new("h", shortest(value))
        elif i < j:
            g = shortest(-value * raw[j, i])
            sign = -1 if g.could_extract_minus_sign() else 1
            found[i, j] = names.new("g", sign * g)
            found[j, i] = load_sympy().Integer(-sign)
    return found


def _polynomial(value: Any, s: Any, names: Names, letter: str, is_long: bool) -> Any:
    """A polynomial in s that is named, or whose coefficients are, if it is not long."""
    sympy = load_sympy()
    if is_long or not value.has(s):
        return names.new(letter, shortest(value))
    coefficients = sympy.Poly(value, s).all_coeffs()
    power = len(coefficients) - 1
    letters = {0: letter, 1: chr(ord(letter) + 1), 2: chr(ord(letter) + 2)}
    return sympy.Add(
        *(
            names.new(letters[power - k], shortest(c)) * s ** (power - k)
            for k, c in enumerate(coefficients)
        )
    )


def polynomial_of(entries: Entries, n: int, s: Any, names: Names) -> Any:
    """Determinant of entries: by coefficients if they are short, else by a recurrence."""
    sympy = load_sympy()
    if n <= 4 and not any(part.has(s) for part in names.values()):
        powers = sympy.Poly(expanded(entries, n), s).as_dict()
        whole = sympy.Add(*(_signed(c) * s**k for (k,), c in powers.items()))
        if len(str(whole)) <= _EXPANDED:
            return whole
    return determinant(entries, n, names)


def expanded(entries: Entries, n: int) -> Any:
    """Determinant of entries as one sum."""
    return load_sympy().expand(determinant(entries, n, None))


def numerator(entries: Entries, n: int, of: tuple[list[Any], list[Any]], names: Names) -> Any:
    """Determinant times ``c^T Z^-1 b``, for vectors c and b.

    Without circles an element of the adjugate is the product of the couplings on the way, times the
    determinant of what is not on it.
    """
    sympy = load_sympy()
    c, b = of
    ends = [(j, i) for j in range(n) for i in range(n) if c[j] != 0 and b[i] != 0]
    if not is_forest(entries, n):
        bordered = dict(entries)
        bordered |= {(i, n): -value for i, value in enumerate(b) if value != 0}
        bordered |= {(n, j): value for j, value in enumerate(c) if value != 0}
        return determinant(bordered, n + 1, names)
    total = sympy.Integer(0)
    for j, i in ends:
        way = find_way(entries, j, i)
        if way is None:
            continue
        couplings = [-entries[one, two] for one, two in itertools.pairwise(way)]
        rest = [k for k in range(n) if k not in way]
        place = {k: new for new, k in enumerate(rest)}
        inner = {(place[x], place[y]): v for (x, y), v in entries.items() if {x, y} <= {*rest}}
        minor = determinant(face_to_face(inner, names), len(rest), names)
        total += sympy.Mul(c[j], b[i], *couplings) * minor
    return total


def face_to_face(entries: Entries, names: Names) -> Entries:
    """The same determinant, if there are no circles, with products of couplings, named."""
    found = dict(entries)
    for (i, j), value in entries.items():
        if i < j:
            g = shortest(-value * entries[j, i])
            sign = -1 if g.could_extract_minus_sign() else 1
            found[i, j], found[j, i] = names.new("g", sign * g), load_sympy().Integer(-sign)
    return found


def _signed(coefficient: Any) -> Any:
    """A sum of negative terms as the negative of a sum."""
    sympy = load_sympy()
    terms = sympy.Add.make_args(coefficient)
    most = max(len(term.free_symbols) for term in terms)
    largest = [term for term in terms if len(term.free_symbols) == most]
    if 2 * sum(term.could_extract_minus_sign() for term in largest) <= len(largest):
        return coefficient
    return sympy.Mul(-1, -coefficient, evaluate=False)


def closed_roots(polynomial: Any, last: Any, x: Any, names: Names) -> list[Any]:
    """Up to four real roots of a polynomial that has only real ones, ascending, not negative.

    Parameters
    ----------
    polynomial : sympy expression
        Its first coefficient is one, its coefficients hold parts.
    last : sympy expression
        Product of the roots, for which a formula without differences is known. The smallest ones
        follow from it, so that they keep all digits.
    """
    sympy = load_sympy()
    _, *rest = sympy.Poly(polynomial, x).all_coeffs()
    n = len(rest)
    new = names.new
    c = [new("c", sympy.sympify((-1) ** (k + 1) * r)) for k, r in enumerate(rest[:-1])]
    product = shortest(last) if n == 1 else new("c", shortest(last))
    if n == 1:
        return [product]
    if n == 2:
        large = new("r", c[0] / 2 + sympy.sqrt(c[0] ** 2 / 4 - product))
        return [product / large, large]
    return (_three if n == 3 else _four)([*c, product], new)


def _three(c: list[Any], new: Callable[[str, Any], Any]) -> list[Any]:
    """By the cosine of a third of an angle; the smallest by the product."""
    sympy = load_sympy()
    mean = c[0] / 3
    p = new("p", mean**2 - c[1] / 3)
    q = new("q", mean**3 - mean * c[1] / 2 + c[2] / 2)
    angle = new("t", sympy.acos(q / p ** sympy.Rational(3, 2)) / 3)
    large = new("r", mean + 2 * sympy.sqrt(p) * sympy.cos(angle))
    middle = new("r", mean + 2 * sympy.sqrt(p) * sympy.cos(angle - 2 * sympy.pi / 3))
    return [c[2] / (large * middle), middle, large]


def _four(c: list[Any], new: Callable[[str, Any], Any]) -> list[Any]:
    """Two pairs by Ferrari, the sum of the larger ones by the largest root of his cubic."""
    sympy = load_sympy()
    third = sympy.Rational(1, 3)
    p = new("p", c[1] - sympy.Rational(3, 8) * c[0] ** 2)
    q = new("q", -(c[0] ** 3) / 8 + c[0] * c[1] / 2 - c[2])
    d = new("d", c[1] ** 2 - 3 * c[0] * c[2] + 12 * c[3])
    e = new(
        "e",
        2 * c[1] ** 3
        - 9 * c[0] * c[1] * c[2]
        + 27 * c[2] ** 2
        + 27 * c[0] ** 2 * c[3]
        - 72 * c[1] * c[3],
    )
    angle = new("t", third * sympy.acos(e / (2 * d ** sympy.Rational(3, 2))))
    half = new("w", sympy.sqrt((sympy.sqrt(d) * sympy.cos(angle) - p) / 6))
    split = new("v", sympy.sqrt(-4 * half**2 - 2 * p - q / half) / 2)
    large = [new("r", c[0] / 4 + half - split), new("r", c[0] / 4 + half + split)]
    pair = new("m", c[3] / (large[0] * large[1]))
    total = new("u", (c[2] - pair * (large[0] + large[1])) / (large[0] * large[1]))
    upper = new("r", total / 2 + sympy.sqrt(total**2 / 4 - pair))
    return [pair / upper, upper, *large]
