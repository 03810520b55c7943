"""Converters of torque and speed, and clutches of gearboxes with their heat."""
