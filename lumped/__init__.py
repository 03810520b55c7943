"""Acausal lumped-parameter modelling of drive trains on CasADi."""

from lumped import ops, profiles
from lumped.analysis.campbell import Campbell, CriticalSpeed, campbell, critical_speeds
from lumped.analysis.design import Optimum
from lumped.analysis.eigen_sensitivity import EigenSensitivity, eigen_sensitivity
from lumped.analysis.energies import ModalEnergies, modal_energies
from lumped.analysis.equilibrium import equilibrium
from lumped.analysis.functionals import (
    clearance,
    damping,
    final,
    frequency,
    mean,
    peak,
    rms,
    swing,
)
from lumped.analysis.identify import Identification, identify
from lumped.analysis.inverse import inverse
from lumped.analysis.linearise import Linearisation, linearise
from lumped.analysis.modes import Modes, modes
from lumped.analysis.motion import Motion, motion
from lumped.analysis.optimise import optimise
from lumped.analysis.pareto import Front, pareto
from lumped.analysis.response import FrequencyResponse, Peak, frequency_response
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
    "Campbell",
    "Component",
    "Connection",
    "CriticalSpeed",
    "EigenSensitivity",
    "Equation",
    "Event",
    "Expr",
    "Flange",
    "FrequencyResponse",
    "Front",
    "HeatPort",
    "Identification",
    "Input",
    "LinearFlange",
    "Linearisation",
    "ModalEnergies",
    "Modes",
    "Motion",
    "OperatingPoint",
    "Optimum",
    "Output",
    "Param",
    "Peak",
    "Pin",
    "Port",
    "Sensitivity",
    "Sizing",
    "Statistics",
    "System",
    "Trajectory",
    "Var",
    "assemble",
    "campbell",
    "chain",
    "clearance",
    "compose",
    "connect",
    "critical_speeds",
    "damping",
    "der",
    "eigen_sensitivity",
    "equilibrium",
    "final",
    "frequency",
    "frequency_response",
    "hold",
    "identify",
    "inverse",
    "linearise",
    "lossless",
    "mean",
    "modal_energies",
    "modes",
    "motion",
    "ops",
    "optimise",
    "param",
    "pareto",
    "peak",
    "profiles",
    "rms",
    "sensitivity",
    "simulate",
    "sizing",
    "start_point",
    "swing",
    "time",
    "var",
    "when",
]
