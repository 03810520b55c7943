from lumped.points.equilibrium import equilibrium as equilibrium
from lumped.points.equilibrium_sensitivity import EquilibriumSensitivity as EquilibriumSensitivity
from lumped.points.equilibrium_sensitivity import equilibrium_sensitivity as equilibrium_sensitivity
from lumped.points.linearise import Linearisation as Linearisation
from lumped.points.linearise import linearise as linearise
from lumped.points.start import start_point as start_point
from lumped.timeloop.results.operating_point import OperatingPoint as OperatingPoint
