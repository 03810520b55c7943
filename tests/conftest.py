"""Small drive trains that several tests use."""

import gc
import os
import signal
from functools import cache

import pytest
from all_workers import made_once
from hypothesis import HealthCheck, Phase, settings

# Read when NumPy is loaded. More threads wait for each other at matrices as small as these, and
# take a core from the other worker.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import lumped as lp
from lumped.components import Inertia, Spring, Torque
from lumped.models import machine

# The same examples at every run of the same tests: Hypothesis takes constants from the modules that
# are loaded. --hypothesis-profile=long takes more, and shrinks what fails.
settings.register_profile(
    "default",
    max_examples=10,
    derandomize=True,
    deadline=None,
    database=None,
    phases=(Phase.generate,),
    suppress_health_check=list(HealthCheck),
)
settings.register_profile(
    "long", settings.get_profile("default"), max_examples=1000, phases=tuple(Phase)
)
settings.load_profile("default")


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Without searches for garbage, which would take a third of the time; all of it stays."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(50_000)  # at Python's own, searches take a twentieth of the tests
        gc.enable()


# Shells let what they start in the background ignore interrupts.
signal.signal(signal.SIGINT, signal.default_int_handler)


class TwoMass(lp.Component):
    """Two inertias and a spring, free."""

    a: Inertia = Inertia(J=2.0)
    shaft: Spring = Spring(c=300.0)
    b: Inertia = Inertia(J=1.0)

    def connections(self):
        yield from lp.chain(self.a, self.shaft, self.b)


class DrivenMass(lp.Component):
    """One inertia and a torque."""

    drive: Torque = Torque(tau=3.0)
    body: Inertia = Inertia(J=2.0)

    def connections(self):
        yield from lp.chain(self.drive, self.body)


@pytest.fixture
def two_mass():
    return TwoMass()


@pytest.fixture
def driven_mass():
    return DrivenMass()


@pytest.fixture(scope="session")
def machine_rows(tmp_path_factory):
    """Published and computed numbers of a machine by its name, computed once for all workers."""

    @cache
    def rows(name):
        return made_once(tmp_path_factory, f"rows_{name}", lambda _: machine(name).rows())

    return rows
