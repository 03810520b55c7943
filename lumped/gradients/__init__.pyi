from lumped.gradients.gradient import Gradient as Gradient
from lumped.gradients.gradient import gradient as gradient
from lumped.gradients.hessian import Hessian as Hessian
from lumped.gradients.hessian import hessian as hessian
from lumped.gradients.sensitivity import Sensitivity as Sensitivity
from lumped.gradients.sensitivity import sensitivity as sensitivity
