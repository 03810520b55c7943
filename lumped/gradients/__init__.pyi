from lumped.gradients.gradient import Gradient as Gradient
from lumped.gradients.gradient import gradient as gradient
from lumped.gradients.gradient_ensemble import GradientEnsemble as GradientEnsemble
from lumped.gradients.gradient_ensemble import gradient_ensemble as gradient_ensemble
from lumped.gradients.gradient_ensemble import to_jax as to_jax
from lumped.gradients.gradient_ensemble import value_and_gradient as value_and_gradient
from lumped.gradients.sensitivity import sensitivity as sensitivity
from lumped.gradients.sensitivity_result import Sensitivity as Sensitivity
