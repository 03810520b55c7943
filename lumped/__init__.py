"""Acausal lumped-parameter modelling of drive trains on CasADi."""

from lumped import ops, profiles, transmissions
from lumped.compiler.assemble import assemble
from lumped.compiler.parameter_file import read_parameters, write_parameters
from lumped.compiler.system import System
from lumped.drawing.film import animate
from lumped.drawing.page import report_html
from lumped.drawing.schematic import schematic
from lumped.exchange.fmu import ExportedFMU, export_fmu
from lumped.exchange.modelica import export_modelica
from lumped.gradients import functionals
from lumped.gradients.gradient import Gradient, gradient
from lumped.gradients.hessian import Hessian, hessian
from lumped.gradients.sensitivity import Sensitivity, sensitivity
from lumped.language.check_units import check_units
from lumped.language.component import Component
from lumped.language.connection import Connection, chain, compose, connect
from lumped.language.expression import Equation, Expr, der, time
from lumped.language.port import Flange, HeatPort, LinearFlange, Pin, Port, lossless
from lumped.language.quantity import Input, Output, Param, Var, param, var
from lumped.language.switch import hold, when
from lumped.optimisation.design import Optimum
from lumped.optimisation.identify import Identification, identify
from lumped.optimisation.motion import Motion, motion
from lumped.optimisation.optimise import optimise
from lumped.optimisation.pareto import Front, pareto
from lumped.orbits.flywheel import Flywheel, flywheel
from lumped.orbits.orbit import PeriodicOrbit
from lumped.orbits.orbit_sensitivity import OrbitSensitivity
from lumped.orbits.periodic import periodic
from lumped.points.equilibrium import equilibrium
from lumped.points.equilibrium_sensitivity import EquilibriumSensitivity, equilibrium_sensitivity
from lumped.points.linearise import Linearisation, linearise
from lumped.points.start import start_point
from lumped.simulation.certify import Certificate
from lumped.simulation.inverse import inverse
from lumped.simulation.simulate import simulate
from lumped.simulation.sizing import Sizing, sizing
from lumped.simulation.sweep import Sweep, sweep
from lumped.simulation.work_precision import WorkPrecision, WorkRow, work_precision
from lumped.timeloop.result import Event, OperatingPoint, Statistics, Trajectory
from lumped.timeloop.result_files import Saved, load
from lumped.vibration.campbell import Campbell, CriticalSpeed, campbell, critical_speeds
from lumped.vibration.eigen_sensitivity import EigenSensitivity, eigen_sensitivity
from lumped.vibration.energies import ModalEnergies, Node, modal_energies
from lumped.vibration.modes import Modes, modes
from lumped.vibration.order_analysis import Order, orders, turns
from lumped.vibration.participation import Participation, participation
from lumped.vibration.response import FrequencyResponse, Peak, frequency_response
from lumped.vibration.response_sensitivity import ResponseSensitivity, response_sensitivity
from lumped.vibration.root_locus import RootLocus, root_locus
from lumped.vibration.shape_sensitivity import ShapeSensitivity, shape_sensitivity
from lumped.vibration.symbolic import expression, symbolic_frequencies

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
