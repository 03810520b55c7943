from lumped.orbits.flywheel import Flywheel as Flywheel
from lumped.orbits.flywheel import flywheel as flywheel
from lumped.orbits.orbit import PeriodicOrbit as PeriodicOrbit
from lumped.orbits.orbit_sensitivity import OrbitSensitivity as OrbitSensitivity
from lumped.orbits.periodic import periodic as periodic
