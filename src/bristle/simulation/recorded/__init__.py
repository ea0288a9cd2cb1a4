"""Loops of a log, open or closed, that can be simulated with any model."""
