"""How much each state takes part in each mode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lumped.errors import OptionError
from lumped.support.arguments import checked
from lumped.support.arrays import Complex
from lumped.support.ranking import list_largest
from lumped.support.rich_html import RichHtml
from lumped.vibration.natural.modes import Modes


@dataclass(frozen=True, eq=False)
class Participation(RichHtml):
    """Participation factors of the oscillating modes.

    Attributes
    ----------
    modes : Modes
        Whose factors they are.
    factors : ndarray of complex, shape (k, n)
        In the order of ``modes.system.state_names``; each row sums to 1.
    """

    modes: Modes
    factors: Complex

    @checked
    def ranked(self, mode: int) -> list[tuple[str, float]]:
        """States and magnitudes of their factors in a mode, the largest first.

        Raises
        ------
        OptionError
            If there is no such mode.
        """
        self.modes.check_mode(mode, "participation")
        size = np.abs(self.factors[mode])
        names = self.modes.system.state_names
        order = np.argsort(-size, kind="stable").tolist()
        return [(names[i], float(size[i])) for i in order if size[i] > 1e-12]

    def __repr__(self) -> str:
        rows = [
            (list_largest(self.ranked(i), "{} {:.3f}", 5),)
            for i in range(min(len(self.factors), 30))
        ]
        head = f"{self.modes.system.name}: {self.modes.accuracy}\n"
        return head + self.modes.list_modes(("participation",), rows)


@checked
def participation(modes: Modes) -> Participation:
    """Participation factors ``conj(y_i) x_i`` of states in modes.

    ``x`` and ``y`` are right and left eigenvectors with ``y^H x == 1``; the factors do not depend
    on units (Perez-Arriaga, Verghese and Schweppe, IEEE Trans. Power Apparatus and Systems 101,
    1982). They say where a mode is seen and acted upon at once: which states of motor and control
    belong to it as well as which torsions and speeds. A factor is also the derivative of the
    eigenvalue by the diagonal entry of the state matrix.

    Parameters
    ----------
    modes : Modes
        From `lumped.modes`; eigenvalues that repeat in one connected drive have no factors of
        their own (nan or large numbers).

    Returns
    -------
    Participation

    Raises
    ------
    OptionError
        If there is no oscillating mode.
    """
    if not len(modes.eigenvalues):
        raise OptionError(f"{modes.system.name}: no oscillating mode.")
    return Participation(modes, (modes.left_vectors.conj() * modes.vectors).T)
