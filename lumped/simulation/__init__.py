"""Runs in time, and what they are made for: certificates, sweeps, inverse, sizing."""
