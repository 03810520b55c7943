from lumped.tolerances.chaos import PolynomialSpread as PolynomialSpread
from lumped.tolerances.scatter import Scatter as Scatter
from lumped.tolerances.scatter import scatter as scatter
from lumped.tolerances.sobol_indices import SobolIndices as SobolIndices
from lumped.tolerances.sobol_indices import sobol_indices as sobol_indices
from lumped.tolerances.spread import Spread as Spread
from lumped.tolerances.toleranced import toleranced as toleranced
