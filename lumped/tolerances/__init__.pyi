from lumped.tolerances.form import DesignPoint as DesignPoint
from lumped.tolerances.reliability import reliability as reliability
from lumped.tolerances.reliability_outcome import Reliability as Reliability
from lumped.tolerances.scene import Scene as Scene
from lumped.tolerances.scene import scene_of as scene_of
