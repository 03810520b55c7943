from lumped.vibration.formulas.formula import Formula as Formula
from lumped.vibration.formulas.symbolic import SymbolicDrive as SymbolicDrive
from lumped.vibration.formulas.symbolic import formula as formula
from lumped.vibration.formulas.symbolic import symbolic as symbolic
from lumped.vibration.inertias.holzer import ElasticPart as ElasticPart
from lumped.vibration.inertias.holzer import Holzer as Holzer
from lumped.vibration.inertias.holzer import InertialPart as InertialPart
from lumped.vibration.inertias.mass_elastic import MassElastic as MassElastic
from lumped.vibration.inertias.mass_elastic import mass_elastic as mass_elastic
from lumped.vibration.natural.eigen_sensitivity import EigenSensitivity as EigenSensitivity
from lumped.vibration.natural.eigen_sensitivity import eigen_sensitivity as eigen_sensitivity
from lumped.vibration.natural.energies import ModalEnergies as ModalEnergies
from lumped.vibration.natural.energies import Node as Node
from lumped.vibration.natural.energies import Participation as Participation
from lumped.vibration.natural.energies import modal_energies as modal_energies
from lumped.vibration.natural.energies import participation as participation
from lumped.vibration.natural.find_modes import modes as modes
from lumped.vibration.natural.modes import Modes as Modes
from lumped.vibration.natural.natural_modes import NaturalModes as NaturalModes
from lumped.vibration.natural.natural_modes import natural_modes as natural_modes
from lumped.vibration.natural.root_locus import RootLocus as RootLocus
from lumped.vibration.natural.root_locus import root_locus as root_locus
from lumped.vibration.natural.shape_sensitivity import ShapeSensitivity as ShapeSensitivity
from lumped.vibration.natural.shape_sensitivity import shape_sensitivity as shape_sensitivity
from lumped.vibration.natural.symbolic import expression as expression
from lumped.vibration.ordered.linearity import Linearity as Linearity
from lumped.vibration.ordered.order_amplitudes import OrderAmplitudes as OrderAmplitudes
from lumped.vibration.ordered.order_analysis import Order as Order
from lumped.vibration.ordered.order_analysis import mesh_orders as mesh_orders
from lumped.vibration.ordered.order_analysis import orders as orders
from lumped.vibration.ordered.order_analysis import turns as turns
from lumped.vibration.ordered.order_response import OrderResponse as OrderResponse
from lumped.vibration.ordered.order_response import order_response as order_response
from lumped.vibration.ordered.order_sensitivity import OrderSensitivity as OrderSensitivity
from lumped.vibration.ordered.order_sensitivity import order_sensitivity as order_sensitivity
from lumped.vibration.ordered.order_tracks import OrderTracks as OrderTracks
from lumped.vibration.ordered.order_tracks import order_tracks as order_tracks
from lumped.vibration.ordered.synthesis import Synthesis as Synthesis
from lumped.vibration.ordered.vector_sums import VectorSums as VectorSums
from lumped.vibration.ordered.vector_sums import vector_sums as vector_sums
from lumped.vibration.responses.correlation import ResponseComparison as ResponseComparison
from lumped.vibration.responses.correlation import compare_response as compare_response
from lumped.vibration.responses.correlation import frac as frac
from lumped.vibration.responses.correlation import mac as mac
from lumped.vibration.responses.response import FrequencyResponse as FrequencyResponse
from lumped.vibration.responses.response import Resonance as Resonance
from lumped.vibration.responses.response import frequency_response as frequency_response
from lumped.vibration.responses.response_sensitivity import (
    ResponseSensitivity as ResponseSensitivity,
)
from lumped.vibration.responses.response_sensitivity import (
    response_sensitivity as response_sensitivity,
)
from lumped.vibration.rules.engine_rule import EngineShaft as EngineShaft
from lumped.vibration.rules.limits import Limit as Limit
from lumped.vibration.rules.limits import torque_reversal as torque_reversal
from lumped.vibration.rules.marine_rule import MarineShaft as MarineShaft
from lumped.vibration.rules.separation import separation as separation
from lumped.vibration.rules.verdict import Verdict as Verdict
from lumped.vibration.rules.verdict import verdict as verdict
from lumped.vibration.speeds.campbell import BarredRange as BarredRange
from lumped.vibration.speeds.campbell import Campbell as Campbell
from lumped.vibration.speeds.campbell import CriticalSpeed as CriticalSpeed
from lumped.vibration.speeds.campbell import campbell as campbell
from lumped.vibration.speeds.campbell import critical_speeds as critical_speeds
from lumped.vibration.speeds.mean_campbell import (
    critical_sensitivity as critical_sensitivity,
)
from lumped.vibration.speeds.mean_campbell import mean_campbell as mean_campbell
from lumped.vibration.speeds.mean_spectrum import mean_modes as mean_modes
from lumped.vibration.speeds.torque_lines import LineCrossing as LineCrossing
from lumped.vibration.speeds.torque_lines import TorqueLine as TorqueLine
from lumped.vibration.speeds.torque_lines import line_crossings as line_crossings
from lumped.vibration.speeds.torque_lines import sine_triangle_lines as sine_triangle_lines
from lumped.vibration.speeds.torque_lines import six_pulse_lines as six_pulse_lines
