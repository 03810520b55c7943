"""Acausal lumped-parameter modelling of drive trains on CasADi."""

from lumped import ops, profiles, transmissions
from lumped.analysis import functionals
from lumped.analysis.campbell import Campbell, CriticalSpeed, campbell, critical_speeds
from lumped.analysis.certify import Certificate
from lumped.analysis.design import Optimum
from lumped.analysis.eigen_sensitivity import EigenSensitivity, eigen_sensitivity
from lumped.analysis.energies import ModalEnergies, Node, modal_energies
from lumped.analysis.equilibrium import equilibrium
from lumped.analysis.equilibrium_sensitivity import (
    EquilibriumSensitivity,
    equilibrium_sensitivity,
)
from lumped.analysis.flywheel import Flywheel, flywheel
from lumped.analysis.gradient import Gradient, gradient
from lumped.analysis.hessian import Hessian, hessian
from lumped.analysis.identify import Identification, identify
from lumped.analysis.inverse import inverse
from lumped.analysis.linearise import Linearisation, linearise
from lumped.analysis.locus import RootLocus, root_locus
from lumped.analysis.modes import Modes, modes
from lumped.analysis.motion import Motion, motion
from lumped.analysis.optimise import optimise
from lumped.analysis.orbit import PeriodicOrbit
from lumped.analysis.orbit_sensitivity import OrbitSensitivity
from lumped.analysis.orders import Order, orders, turns
from lumped.analysis.pareto import Front, pareto
from lumped.analysis.participation import Participation, participation
from lumped.analysis.periodic import periodic
from lumped.analysis.response import FrequencyResponse, Peak, frequency_response
from lumped.analysis.response_sensitivity import ResponseSensitivity, response_sensitivity
from lumped.analysis.result import Event, OperatingPoint, Statistics, Trajectory
from lumped.analysis.sensitivity import Sensitivity, sensitivity
from lumped.analysis.shape_sensitivity import ShapeSensitivity, shape_sensitivity
from lumped.analysis.simulate import simulate
from lumped.analysis.sizing import Sizing, sizing
from lumped.analysis.start import start_point
from lumped.analysis.store import Saved, load
from lumped.analysis.sweep import Sweep, sweep
from lumped.analysis.symbolic import expression, symbolic_frequencies
from lumped.analysis.work_precision import WorkPrecision, WorkRow, work_precision
from lumped.assemble import assemble
from lumped.component import Component
from lumped.connection import Connection, chain, compose, connect
from lumped.dimension import check_units
from lumped.exchange.fmu import ExportedFMU, export_fmu
from lumped.exchange.modelica import export_modelica
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
    "Certificate",
    "Component",
    "Connection",
    "CriticalSpeed",
    "EigenSensitivity",
    "Equation",
    "EquilibriumSensitivity",
    "Event",
    "ExportedFMU",
    "Expr",
    "Flange",
    "Flywheel",
    "FrequencyResponse",
    "Front",
    "Gradient",
    "HeatPort",
    "Hessian",
    "Identification",
    "Input",
    "LinearFlange",
    "Linearisation",
    "ModalEnergies",
    "Modes",
    "Motion",
    "Node",
    "OperatingPoint",
    "Optimum",
    "OrbitSensitivity",
    "Order",
    "Output",
    "Param",
    "Participation",
    "Peak",
    "PeriodicOrbit",
    "Pin",
    "Port",
    "ResponseSensitivity",
    "RootLocus",
    "Saved",
    "Sensitivity",
    "ShapeSensitivity",
    "Sizing",
    "Statistics",
    "Sweep",
    "System",
    "Trajectory",
    "Var",
    "WorkPrecision",
    "WorkRow",
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
    "equilibrium_sensitivity",
    "export_fmu",
    "export_modelica",
    "expression",
    "flywheel",
    "frequency_response",
    "functionals",
    "gradient",
    "hessian",
    "hold",
    "identify",
    "inverse",
    "linearise",
    "load",
    "lossless",
    "modal_energies",
    "modes",
    "motion",
    "ops",
    "optimise",
    "orders",
    "param",
    "pareto",
    "participation",
    "periodic",
    "profiles",
    "read_parameters",
    "report_html",
    "response_sensitivity",
    "root_locus",
    "schematic",
    "sensitivity",
    "shape_sensitivity",
    "simulate",
    "sizing",
    "start_point",
    "sweep",
    "symbolic_frequencies",
    "time",
    "transmissions",
    "turns",
    "var",
    "when",
    "work_precision",
    "write_parameters",
]
