"""How exact and how fast are problems that others published?

Models as a user writes them, of bodies, joints and whole equations, without preferred states or
other hints, at four tolerances; beside them SciPy's Radau and CVODE's BDF (scikit-sundae, the extra
`bench`) with right-hand sides in NumPy by hand, mechanisms reduced by hand too, absolute tolerances
1e-3 of the relative ones. Errors are those at the end, against the published reference, relative to
it; where a quantity passes zero, to its largest value (`largest`). lumped's times are the best of
several compiled runs. Then friction oscillators with exact solutions, and natural frequencies.

    python -m benchmarks.published
"""


def main() -> None:
    """Measure all, write the results and draw them."""
    from benchmarks.published import compare

    compare.main()
