"""Taylor coefficients of states as LLVM assembly.

A function becomes ``void name(x, p, t, m, out)`` with the arguments of `emit_llvm`; it writes the
coefficients of the states of orders 0, 1, ... up to a fixed one, each order after the other. At
order k all sums over lower orders are taken in loops of their own, and the rest needs no loop. For
several lanes each number is a vector of as many; else four sums at a time are one vector, so what
is multiplied lies side by side, if need be more than once.
"""

from __future__ import annotations

from lumped.code.emit_llvm import ARGUMENTS, Body, make_room
from lumped.code.operations import RESULT, Operations
from lumped.code.taylor import Kind, Recurrence, Series, series_of
from lumped.code.taylor_places import TOGETHER, Factor, Group, Pair, Places, factors_of

_MOST_VECTORS = 8
"""Vectors in one loop."""
_MOST_ON_STACK = 16384
_OWN = "ptr noalias %h, ptr noalias %c"

Row = tuple[int, int, int, int]


def series_assembly(
    function: Operations, name: str, order: int, states: int, lanes: int = 1
) -> str:
    """LLVM assembly of the coefficients of states and integrals.

    Results of the function are the rates of the states, then what is integrated from zero on.

    Raises
    ------
    UnsupportedError
        If what varies goes through an operation without Taylor coefficients.
    """
    series = series_of(function)
    places = Places(series, lanes)
    needed: set[str] = set()
    time = "double" if lanes == 1 else "ptr"
    given = ARGUMENTS.format(time)
    passed = f"ptr %x, ptr %p, {time} %t, ptr %m, ptr %out, ptr %h, ptr %c"
    parts, firsts, laters = [], [], []
    for k, rows in enumerate(places.first_chunks):
        first = _First(series, places, needed, lanes, function.results)
        lines = first.lines_of(rows, 0 if k else states)
        head = f"define internal void @{name}_first_{k}({given}, {_OWN}) noinline"
        parts.append("\n".join([f"{head} {{", *lines, "  ret void\n}"]))
        firsts.append(f"  call void @{name}_first_{k}({passed})")
    for k, chunk in enumerate(places.later_chunks):
        later = _Later(places, needed, lanes, function.results)
        lines = later.lines_of(chunk, places.groups[k])
        head = f"define internal void @{name}_later_{k}(ptr noalias %out, {_OWN}, i64 %k) noinline"
        parts.append("\n".join([f"{head} {{\nentry:", *lines, "  ret void\n}"]))
        laters.append(f"  call void @{name}_later_{k}(ptr %out, ptr %h, ptr %c, i64 %k)")
    sizes = places.width * order * lanes, max(len(places.fixed), 1) * lanes
    rooms = [
        make_room(symbol, size, sum(sizes) <= _MOST_ON_STACK, needed)
        for symbol, size in zip("hc", sizes, strict=True)
    ]
    body = [*(begin for begin, _ in rooms), *firsts, "  br label %orders", "orders:"]
    body += ["  %k = phi i64 [1, %entry], [%next, %orders]", *laters]
    body += ["  %next = add i64 %k, 1", f"  %done = icmp sge i64 %next, {order}"]
    body += ["  br i1 %done, label %end, label %orders", "end:"]
    body.append("".join(end for _, end in rooms) + "  ret void\n}")
    parts.append("\n".join([f"define void @{name}({given}) {{\nentry:", *body]))
    return "\n".join([*parts, *sorted(needed)])


class _First(Body):
    """Order zero."""

    def __init__(
        self, series: Series, places: Places, needed: set[str], lanes: int, width: int
    ) -> None:
        super().__init__(series.constants, needed, lanes)
        self._places, self._width = places, width

    def lines_of(self, rows: list[Row], states: int) -> list[str]:
        """Instructions of a chunk; the first one takes the states over."""
        places = self._places
        for i in range(self._width if states else 0):
            value = self._load("x", i) if i < states else self._constant(0.0)
            self._store(value, "out", i)
        own = {row[1] for row in rows if row[0] != RESULT}
        live = {v for v in own if (False, v) in places.kept or v in places.fixed}
        return self.lines([list(row) for row in rows], live)

    def _load_kept(self, place: int) -> str:
        columns = self._places.kept.get((False, place))
        if columns is not None:
            return self._load("h", columns[0])
        return self._load("c", self._places.fixed[place])

    def _keep(self, value: str, place: int) -> None:
        if (False, place) in self._places.kept:
            self._store(value, "h", self._places.kept[False, place][0])
        if place in self._places.fixed:
            self._store(value, "c", self._places.fixed[place])

    def _give(self, value: str, place: int) -> None:
        self._store(value, "out", self._width + place)


class _Later(Body):
    """Order k, from one on."""

    def __init__(self, places: Places, needed: set[str], lanes: int, width: int) -> None:
        super().__init__([], needed, lanes)
        self._places, self._width = places, width
        self._block = "entry"
        self._held: dict[int, str] = {}

    def lines_of(self, rows: list[Recurrence], groups: list[Group]) -> list[str]:
        """Instructions of a chunk."""
        kind, one, zero = self._number, self._constant(1.0), self._constant(0.0)
        order = self._put("uitofp i64 %k to double")
        self._order = self._spread(order, self._lanes)
        self._over = self._put(f"fdiv {kind} {one}, {self._order}")
        after = self._put(f"fadd {kind} {self._order}, {one}")
        over_next = self._put(f"fdiv {kind} {one}, {after}")
        self._row = self._put(f"mul i64 %k, {self._places.width}")
        row = self._put(f"mul i64 %k, {self._width}")
        sums = self._sums(groups)
        for r in rows:
            if r.kind == Kind.WRITTEN:
                found = zero
                if r.a >= 0:
                    found = self._put(f"fmul {kind} {self._get(r.a)}, {over_next}")
                self._store_from("out", row, self._width + r.value, found)
                continue
            if r.kind == Kind.OF_STATE:
                found = self._load_from("out", row, r.a)
            elif r.kind == Kind.OF_TIME:
                is_first = self._put("icmp eq i64 %k, 1")
                found = self._put(f"select i1 {is_first}, {kind} {one}, {kind} {zero}")
            elif (factors := factors_of(r)) is not None:
                found = self._by_sum(r, sums[factors])
            else:
                found = self._linear(r)
            self._held[r.value] = found
            for column in self._places.kept.get((False, r.value), ()):
                self._store_from("h", self._row, column, found)
            if (True, r.value) in self._places.kept:
                found = self._put(f"fmul {kind} {self._order}, {found}")
            for column in self._places.kept.get((True, r.value), ()):
                self._store_from("h", self._row, column, found)
        return self._text

    def _linear(self, r: Recurrence) -> str:
        kind, a = self._number, self._get(r.a)
        if r.kind == Kind.COPIED:
            return a
        if r.kind == Kind.NEGATIVE:
            return self._put(f"fneg {kind} {a}")
        if r.kind == Kind.TWICE:
            return self._put(f"fadd {kind} {a}, {a}")
        if r.kind == Kind.SCALED:
            return self._put(f"fmul {kind} {self._load_value(r.b)}, {a}")
        if r.kind == Kind.CHOSEN:
            zero = self._constant(0.0)
            is_on = self._put(f"fcmp une {kind} {self._load_value(r.b)}, {zero}")
            return self._select(is_on, a, zero)
        word = {Kind.SUM: "fadd", Kind.DIFFERENCE: "fsub"}[r.kind]
        return self._put(f"{word} {kind} {a}, {self._get(r.b)}")

    def _by_sum(self, r: Recurrence, total: str) -> str:
        """A coefficient from the sum over the orders between, and its ends."""
        kind = self._number
        if r.kind == Kind.PRODUCT:
            first = self._put(f"fmul {kind} {self._get(r.a)}, {self._begin((False, r.b))}")
            last = self._put(f"fmul {kind} {self._begin((False, r.a))}, {self._get(r.b)}")
            ends = self._put(f"fadd {kind} {first}, {last}")
            return self._put(f"fadd {kind} {total}, {ends}")
        if r.kind == Kind.INTEGRAL:
            slope = self._put(f"fmul {kind} {self._order}, {self._get(r.a)}")
            first = self._put(f"fmul {kind} {slope}, {self._begin((False, r.b))}")
            whole = self._put(f"fadd {kind} {total}, {first}")
            found = self._put(f"fmul {kind} {whole}, {self._over}")
            return found if r.sign > 0 else self._put(f"fneg {kind} {found}")
        if r.kind == Kind.QUOTIENT:
            last = self._put(f"fmul {kind} {self._get(r.b)}, {self._begin((False, r.value))}")
            total = self._put(f"fadd {kind} {total}, {last}")
        over = self._get(r.a) if r.a >= 0 else self._constant(0.0)
        rest = self._put(f"fsub {kind} {over}, {total}")
        return self._put(f"fmul {kind} {rest}, {self._load_value(r.factor)}")

    def _get(self, value: int) -> str:
        """The coefficient of the present order."""
        if value not in self._held:
            column = self._places.kept[False, value][0]
            self._held[value] = self._load_from("h", self._row, column)
        return self._held[value]

    def _begin(self, factor: Factor) -> str:
        """A value at order zero."""
        return self._load("h", self._places.kept[factor][0])

    def _load_value(self, value: int) -> str:
        return self._load("c", self._places.fixed[value])

    def _place_from(self, base: str, row: str, column: int) -> str:
        begin = self._put(f"getelementptr inbounds {self._number}, ptr %{base}, i64 {row}")
        return self._put(f"getelementptr inbounds {self._number}, ptr {begin}, i64 {column}")

    def _load_from(self, base: str, row: str, column: int) -> str:
        place = self._place_from(base, row, column)
        return self._put(f"load {self._number}, ptr {place}, align 8")

    def _store_from(self, base: str, row: str, column: int, value: str) -> None:
        place = self._place_from(base, row, column)
        self._text.append(f"  store {self._number} {value}, ptr {place}, align 8")

    def _sums(self, groups: list[Group]) -> dict[Pair, str]:
        """Sums over the orders between zero and k, of one factor's rising, the other's falling."""
        found: dict[Pair, str] = {}
        vector = f"<{TOGETHER} x double>"
        # of lanes, more sums than these would not stay in registers
        count = _MOST_VECTORS if self._lanes == 1 else 1
        for k in range(0, len(groups), count):
            part = groups[k : k + count]
            if part[0].is_vector:
                sides = [(group.left[0], group.right[0]) for group in part]
                for group, sums in zip(part, self._loop(sides, vector, f"{k}"), strict=True):
                    for i, pair in enumerate(group.pairs):
                        found[pair] = self._put(f"extractelement {vector} {sums}, i32 {i}")
            else:
                pairs = [pair for group in part for pair in group.pairs]
                sides = [s for g in part for s in zip(g.left, g.right, strict=True)]
                found |= zip(pairs, self._loop(sides, self._number, f"{k}"), strict=True)
        return found

    def _loop(self, sides: list[tuple[int, int]], kind: str, label: str) -> list[str]:
        """Sums of products from two columns, one number or vector each."""
        text, before = self._text, self._block
        inside, behind = f"sum{label}", f"after{label}"
        is_any = self._put("icmp sgt i64 %k, 1")
        text.append(f"  br i1 {is_any}, label %{inside}, label %{behind}")
        text.append(f"{inside}:")
        text.append(f"  %j{label} = phi i64 [1, %{before}], [%n{label}, %{inside}]")
        sums = [f"%s{label}.{s}" for s in range(len(sides))]
        for symbol in sums:
            text.append(
                f"  {symbol} = phi {kind} [zeroinitializer, %{before}], [{symbol}n, %{inside}]"
            )
        rising = self._put(f"mul i64 %j{label}, {self._places.width}")
        falling = self._put(f"sub i64 {self._row}, {rising}")
        loaded: dict[tuple[str, int], str] = {}

        def factor(row: str, column: int) -> str:
            if (row, column) not in loaded:
                place = self._place_from("h", row, column)
                loaded[row, column] = self._put(f"load {kind}, ptr {place}, align 8")
            return loaded[row, column]

        for symbol, (a, b) in zip(sums, sides, strict=True):
            part = self._put(f"fmul {kind} {factor(rising, a)}, {factor(falling, b)}")
            text.append(f"  {symbol}n = fadd {kind} {symbol}, {part}")
        text.append(f"  %n{label} = add i64 %j{label}, 1")
        is_done = self._put(f"icmp sge i64 %n{label}, %k")
        text.append(f"  br i1 {is_done}, label %{behind}, label %{inside}")
        text.append(f"{behind}:")
        self._block = behind
        return [
            self._put(f"phi {kind} [zeroinitializer, %{before}], [{symbol}n, %{inside}]")
            for symbol in sums
        ]
