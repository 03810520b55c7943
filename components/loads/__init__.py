"""Loads of machines: torques by the speed, ice, wind, road and hoisting."""
