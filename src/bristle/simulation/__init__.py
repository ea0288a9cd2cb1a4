"""Simulation of experiments: open loop, closed loop, and results."""

from typing import TYPE_CHECKING

from bristle.core.experiment import substeps_for
from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.simulation.compensation import (
        AS_RECORDED,
        COMPENSATED,
        compensation_experiment,
        feedforward_effort,
        friction_along,
        motor_reference,
        on_another_rig,
        open_loop_experiment,
    )
    from bristle.simulation.result import MODES, Prediction, SimulationResult, VariantResult
    from bristle.simulation.run import simulate
    from bristle.simulation.statistics import Statistics, statistics_of, swing_at_worst_reversal, worst_reversal

__getattr__ = loaded_from(__name__)

__all__ = [
    "Prediction",
    "SimulationResult",
    "Statistics",
    "VariantResult",
    "compensation_experiment",
    "feedforward_effort",
    "friction_along",
    "motor_reference",
    "open_loop_experiment",
    "simulate",
    "statistics_of",
    "substeps_for",
]
