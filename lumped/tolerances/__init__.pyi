from lumped.tolerances.form import DesignPoint as DesignPoint
from lumped.tolerances.reliability import reliability as reliability
from lumped.tolerances.reliability_outcome import Reliability as Reliability
from lumped.tolerances.scatter import Scatter as Scatter
from lumped.tolerances.scatter import scatter as scatter
from lumped.tolerances.spread import Spread as Spread
