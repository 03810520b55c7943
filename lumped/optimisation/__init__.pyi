from lumped.optimisation.design import Optimum as Optimum
from lumped.optimisation.identification import Identification as Identification
from lumped.optimisation.identify import identify as identify
from lumped.optimisation.motion import Motion as Motion
from lumped.optimisation.motion import motion as motion
from lumped.optimisation.optimise import optimise as optimise
from lumped.optimisation.pareto import Front as Front
from lumped.optimisation.pareto import pareto as pareto
