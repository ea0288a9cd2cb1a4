"""Simulation of experiments: open loop, closed loop, and results."""

from typing import TYPE_CHECKING

from bristle.core.experiment import substeps_for
from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.simulation.assessment import (
        Assessment,
        Verdict,
        WorkingPoint,
        assess,
        motion_of,
        runnable,
        top_speed,
    )
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
    from bristle.simulation.linear_system import (
        ALIKE,
        PHASE_ENOUGH,
        antiresonance_of,
        sliding_force,
        with_two_masses,
    )
    from bristle.simulation.result import MODES, Prediction, SimulationResult, VariantResult
    from bristle.simulation.run import seeded, simulate
    from bristle.simulation.statistics import (
        Statistics,
        statistics_of,
        swing_at_worst_reversal,
        worst_reversal,
    )
    from bristle.simulation.tuning import (
        RUNS_MAX,
        UNSTATED,
        Delays,
        Proposal,
        delays_of,
        lagging,
        proposals_for,
        with_known_motion,
    )

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
