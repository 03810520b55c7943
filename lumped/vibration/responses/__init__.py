"""Responses to sinusoidal inputs."""
