from lumped.tolerances.scatter import Scatter as Scatter
from lumped.tolerances.scatter import scatter as scatter
from lumped.tolerances.spread import Spread as Spread
from lumped.tolerances.toleranced import toleranced as toleranced
