"""What docs/press.md shows is true."""

import re

import numpy as np
from page_code import read_page
from scipy.integrate import solve_ivp

NAME = "press"
E, R, L = 0.3, 0.1, 0.5
PHASE = 3.14159


def crank_angle(phi):
    x = phi - PHASE
    start = -PHASE + 2 * np.arctan(E * np.sin(-PHASE) / (1 - E * np.cos(-PHASE)))
    return -(x + 2 * np.arctan(E * np.sin(x) / (1 - E * np.cos(x))) - start)


def ram(phi):
    q = crank_angle(phi)
    return R * np.cos(q) + np.sqrt(L**2 - (R * np.sin(q)) ** 2)


def slope(f, phi):
    """Derivative without rounding (Squire and Trapp, SIAM Review 40 (1998) 110)."""
    return f(phi + 1e-30j).imag / 1e-30


def inertia(phi):
    """Reduced to the crankshaft; rod of 60 kg with its centre in the middle."""
    h = 1e-4
    dq = (crank_angle(phi + h) - crank_angle(phi - h)) / (2 * h)
    ds = (ram(phi + h) - ram(phi - h)) / (2 * h)
    q = crank_angle(phi)
    rod = -R * np.cos(q) / np.sqrt(L**2 - (R * np.sin(q)) ** 2) * dq
    pin = (R * dq) ** 2
    moved = 0.5 * 60.0 * pin + (400.0 + 0.5 * 60.0) * ds**2 + (2.0 - 60.0 * 0.25 * L**2) * rod**2
    return 220.0 + 4.0 + 0.15 * 12.0**2 + moved


def rate(_, y):
    phi, w = y
    slip = 1 - 12 * w / 157.0
    motor = 12 * 260.0 * 2 * 0.25 * slip / (slip**2 + 0.25**2)
    ds = slope(ram, phi)
    z = np.clip((ram(phi) - 0.54) / (0.61 - 0.54), 0.0, 1.0)
    middle = 1.0 / 1.2
    shape = (z / middle) * ((1 - z) / (1 - middle)) ** 0.2
    load = 150e3 * shape * np.clip(ds * w / 1e-3, 0.0, 1.0)
    h = 1e-4
    bend = (inertia(phi + h) - inertia(phi - h)) / (2 * h)
    return [w, (motor - load * ds - 0.5 * bend * w**2) / inertia(phi)]


def test_the_press_has_less_than_40_lines_and_follows_a_second_formulation(names):
    (block,) = re.findall(r"```python\n(.*?)```", read_page(NAME), re.DOTALL)
    assert len(block.strip().splitlines()) < 40
    run = names["run"]
    modes = [(e.component, e.after) for e in run.events if e.after in ("stuck", "free")]
    assert modes == [("brake", "free"), ("clutch", "stuck"), ("clutch", "free"), ("brake", "stuck")]
    coupled = (run.t > 0.55) & (run.t < 1.95)
    t, phi, w = run.t[coupled], run["brake.phi"][coupled], run["flywheel.w"][coupled]
    expected = solve_ivp(
        rate, (t[0], t[-1]), [phi[0], w[0]], "DOP853", t, rtol=1e-9, atol=1e-9, max_step=1e-3
    ).y
    error = np.abs(w - expected[1]).max()
    assert error < 1e-5
