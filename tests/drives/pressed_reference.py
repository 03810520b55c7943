"""Friction that is pressed by a contact, in closed form; knows no `lumped`."""

from dataclasses import dataclass

from hybrid_reference import STICK, Drive


@dataclass(frozen=True)
class Pressed:
    """A level that is `mu` times the force of a contact, the only one on its body."""

    mu: float
    by: int
    body: int
    ts: tuple = ()

    def on(self, *_):
        return 1.0, 0.0


class PressedDrive(Drive):
    """A drive some of whose frictions are pressed by contacts."""

    def make(self, modes):
        self.now = modes
        return super().make(modes)

    def line(self, line, factor=1.0):
        if not isinstance(line, Pressed):
            return super().line(line, factor)
        return factor * line.mu * (self.now[line.by] == STICK) * self.force(line.body)

    def force(self, body):
        """Force of a closed contact on a body, as a row: what keeps it from moving."""
        row = -self.smooth[body]
        for p in self.loads:
            row = row - p.row[body] * self.line(p.line)
        for k, p in enumerate(self.waves):
            row[self.one + 2 + 2 * k] -= p.size * p.row[body]
        return row
