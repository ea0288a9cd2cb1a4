"""Simulation of experiments: open loop, closed loop, and what came out."""

from bristle.core.experiment import substeps_for
from bristle.simulation.compensation import compensation_experiment, feedforward_effort, friction_along, open_loop_experiment
from bristle.simulation.result import Prediction, SimulationResult, Statistics, VariantResult, statistics_of
from bristle.simulation.run import simulate

__all__ = [
    "Prediction",
    "SimulationResult",
    "Statistics",
    "VariantResult",
    "compensation_experiment",
    "feedforward_effort",
    "friction_along",
    "open_loop_experiment",
    "simulate",
    "statistics_of",
    "substeps_for",
]
