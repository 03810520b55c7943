from lumped.tolerances.scene import Scene as Scene
from lumped.tolerances.scene import scene_of as scene_of
