from lumped.tolerances.chaos import Chaos as Chaos
from lumped.tolerances.chaos import chaos as chaos
from lumped.tolerances.scene import Scene as Scene
from lumped.tolerances.scene import scene_of as scene_of
from lumped.tolerances.sobol_indices import SobolIndices as SobolIndices
from lumped.tolerances.sobol_indices import sobol_indices as sobol_indices
