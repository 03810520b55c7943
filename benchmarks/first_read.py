"""What does the first read of a quantity of a run cost?

The two masses of `default_call`, 502 output times. A state is read, then a torque that is computed
when it is first asked for, in each of many new runs; in a new system, it is the first quantity that
is ever computed. The baseline is the formula of the torque in NumPy on the states of the run.
Times are the best of several; read the ratios.

    python -m benchmarks.first_read
"""

import numpy as np

import lumped as lp
from benchmarks.default_call import Two
from benchmarks.harness import publish, time_action

ROUNDS, SYSTEMS = 200, 5


def in_numpy(run: lp.Trajectory) -> np.ndarray:
    """Torque of the shaft."""
    twist, a, b = (run[name] for name in ("s.phi_rel", "a.w", "b.w"))
    return 1e4 * twist + 5.0 * (b - a)


def main() -> None:
    """Print the table and write it to the results."""
    best = dict.fromkeys(
        (
            "the torque in NumPy",
            "a state, first read",
            "the torque, first read",
            "the torque, read again",
            "the torque, first read in a new system",
        ),
        np.inf,
    )

    def note(what: str, action) -> None:
        best[what] = min(best[what], time_action(action, 1).seconds)

    for _ in range(SYSTEMS):
        system = lp.assemble(Two())
        run = lp.simulate(system, until=1.0)
        assert "a.w" in run
        note("the torque, first read in a new system", lambda r=run: r["s.tau"])
    for _ in range(ROUNDS):
        run = lp.simulate(system, until=1.0)
        note("a state, first read", lambda r=run: r["a.w"])
        note("the torque, first read", lambda r=run: r["s.tau"])
        note("the torque, read again", lambda r=run: r["s.tau"])
        in_numpy(run)
        note("the torque in NumPy", lambda r=run: in_numpy(r))
    np.testing.assert_allclose(run["s.tau"], in_numpy(run), atol=1e-9)
    base = best["the torque in NumPy"]
    head = ("what", "us", "over NumPy")
    rows = [(what, f"{s * 1e6:.1f}", f"{s / base:.2f}") for what, s in best.items()]
    publish("first_read", head, rows)


if __name__ == "__main__":
    main()
