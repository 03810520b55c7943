"""Small vibrations about steady rotation: the equations, their means and harmonics."""
