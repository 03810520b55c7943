"""Acausal lumped-parameter modelling of drive trains on CasADi."""

from lumped import ops, profiles
from lumped.analysis.campbell import Campbell, CriticalSpeed, campbell, critical_speeds
from lumped.analysis.eigen_sensitivity import EigenSensitivity, eigen_sensitivity
from lumped.analysis.energies import ModalEnergies, Node, modal_energies
from lumped.analysis.equilibrium import equilibrium
from lumped.analysis.inverse import inverse
from lumped.analysis.linearise import Linearisation, linearise
from lumped.analysis.locus import RootLocus, root_locus
from lumped.analysis.modes import Modes, modes
from lumped.analysis.orders import Order, orders
from lumped.analysis.participation import Participation, participation
from lumped.analysis.response import FrequencyResponse, Peak, frequency_response
from lumped.analysis.result import Event, OperatingPoint, Statistics, Trajectory
from lumped.analysis.sensitivity import Sensitivity, sensitivity
from lumped.analysis.simulate import simulate
from lumped.analysis.sizing import Sizing, sizing
from lumped.analysis.start import start_point
from lumped.analysis.store import Saved, load
from lumped.analysis.sweep import Sweep, sweep
from lumped.analysis.symbolic import expression, symbolic_frequencies
from lumped.assemble import assemble
from lumped.component import Component
from lumped.connection import Connection, chain, compose, connect
from lumped.dimension import check_units
from lumped.expression import Equation, Expr, der, time
from lumped.parameter_file import read_parameters, write_parameters
from lumped.pictures.motion import animate
from lumped.pictures.page import report_html
from lumped.pictures.schematic import schematic
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
    "HeatPort",
    "Input",
    "LinearFlange",
    "Linearisation",
    "ModalEnergies",
    "Modes",
    "Node",
    "OperatingPoint",
    "Order",
    "Output",
    "Param",
    "Participation",
    "Peak",
    "Pin",
    "Port",
    "RootLocus",
    "Saved",
    "Sensitivity",
    "Sizing",
    "Statistics",
    "Sweep",
    "System",
    "Trajectory",
    "Var",
    "animate",
    "assemble",
    "campbell",
    "chain",
    "check_units",
    "compose",
    "connect",
    "critical_speeds",
    "der",
    "eigen_sensitivity",
    "equilibrium",
    "expression",
    "frequency_response",
    "hold",
    "inverse",
    "linearise",
    "load",
    "lossless",
    "modal_energies",
    "modes",
    "ops",
    "orders",
    "param",
    "participation",
    "profiles",
    "read_parameters",
    "report_html",
    "root_locus",
    "schematic",
    "sensitivity",
    "simulate",
    "sizing",
    "start_point",
    "sweep",
    "symbolic_frequencies",
    "time",
    "var",
    "when",
    "write_parameters",
]
