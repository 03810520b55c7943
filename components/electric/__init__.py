"""Circuits, motors, drives and heat."""
