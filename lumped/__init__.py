"""Acausal lumped-parameter modelling of drive trains on CasADi."""

from lumped import ops, profiles
from lumped.analysis.equilibrium import equilibrium
from lumped.analysis.inverse import inverse
from lumped.analysis.linearise import Linearisation, linearise
from lumped.analysis.modes import Modes, modes
from lumped.analysis.result import Event, OperatingPoint, Statistics, Trajectory
from lumped.analysis.sensitivity import Sensitivity, sensitivity
from lumped.analysis.simulate import simulate
from lumped.analysis.sizing import Sizing, sizing
from lumped.analysis.start import start_point
from lumped.assemble import assemble
from lumped.component import Component
from lumped.connection import Connection, chain, compose, connect
from lumped.expression import Equation, Expr, der, time
from lumped.port import Flange, HeatPort, LinearFlange, Pin, Port, lossless
from lumped.quantity import Input, Output, Param, Var, param, var
from lumped.switch import hold, when
from lumped.system import System

__version__ = "0.1.0"

__all__ = [
    "Component",
    "Connection",
    "Equation",
    "Event",
    "Expr",
    "Flange",
    "HeatPort",
    "Input",
    "LinearFlange",
    "Linearisation",
    "Modes",
    "OperatingPoint",
    "Output",
    "Param",
    "Pin",
    "Port",
    "Sensitivity",
    "Sizing",
    "Statistics",
    "System",
    "Trajectory",
    "Var",
    "assemble",
    "chain",
    "compose",
    "connect",
    "der",
    "equilibrium",
    "hold",
    "inverse",
    "linearise",
    "lossless",
    "modes",
    "ops",
    "param",
    "profiles",
    "sensitivity",
    "simulate",
    "sizing",
    "start_point",
    "time",
    "var",
    "when",
]
