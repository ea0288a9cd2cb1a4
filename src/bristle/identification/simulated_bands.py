r"""Bands around a simulated prediction of the motion and the effort of a loop.

The simulation is repeated with several draws of the parameters. The additional force

.. math:: d = (c_k - 1)\, F(t) + \varepsilon\, g_j

acts on the plant, with a random friction level :math:`c_k` for each half-cycle `k` of the recorded motion, the friction
force `F` along it, the unexplained force :math:`\varepsilon`, and a standard normal number :math:`g_j` for each
correlation time of the unexplained force. A band around the effort is

.. math:: \hat u \pm 1.96\, \kappa \sqrt{\overline{(u_b - \hat u)^2} + \sigma^2}

where :math:`\sigma` is the measurement noise and :math:`\kappa` the factor from held-out blocks. The band of the
position is

.. math:: \hat q \pm 1.96 \sqrt{\overline{(q_b - \hat q)^2} + \sigma_q^2 + \rho^2}

with the rounding :math:`\sigma_q` of the encoder, and :math:`\rho` for the remaining error of the measured position:
noise and model error in the loop. bristle simulates the log of the identification in the same loop and chooses
:math:`\rho` so that the band contains 95 % of its positions. The spread of the draws is about the prediction. If a force
error accumulates, as in open loop, the spread grows with the error.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.cores import Abreast
from bristle.core.errors import InputError
from bristle.core.normal import NORMAL_95
from bristle.engine.motion import along
from bristle.identification.dataset import Dataset, mechanical, transmitted_by
from bristle.identification.half_cycles import force_with_scatter, half_cycle_starts, least_way
from bristle.identification.preprocessing import CUTOFF_SHARE, segment_of
from bristle.identification.result import Bands, Fit, with_parameters
from bristle.logs.log import Log
from bristle.logs.turns import numbered, reversals, turning_points
from bristle.models.friction import with_presliding
from bristle.simulation.recorded.closed_loop import START_SAMPLES, Course, Stretch, can_be_simulated

# Of a step: 95 % of the rounding errors, uniform over the step, are within 0.475 of it.
ROUNDING = 0.475 / NORMAL_95
SIMULATED = 400_000  # samples of all simulations for the remaining error
FEW, MANY = 3, 12  # simulations
LEFT = {"closed-loop": "left_in_closed_loop", "open-loop": "left_in_open_loop"}


class Widths(NamedTuple):
    """Half-widths of the 95 % bands around position [m or rad] and effort [N or N*m], shape (sample,)."""

    position: np.ndarray
    effort: np.ndarray


def simulated_widths(
    bands: Bands, plant: Model, friction: Model, predicted: Course, stretch: Stretch
) -> Widths:
    """Return the half-widths of the 95 % bands around a simulation; infinite where all other simulations diverged."""
    position, effort = _squares(bands, plant, friction, predicted, stretch, MEMBERS)
    left = getattr(bands, LEFT[stretch.loop])
    return Widths(
        NORMAL_95 * np.sqrt(position + _rounding(stretch) ** 2 + left**2),
        NORMAL_95 * bands.inflation * np.sqrt(effort + bands.noise**2),
    )


def with_loops(fit: Fit, pairs: Sequence[tuple[Log, Axis | None]]) -> Fit:
    """Return a fit with bands that include the position error in simulations of its logs, where they can be simulated."""
    if fit.resampling is None:
        return fit
    bands = fit.resampling.bands
    found: dict[str, float] = {}
    for loop, name in LEFT.items():
        stretches = list[Stretch]()
        for log, axis in pairs:
            axis = axis or Axis(kind=log.kind)
            if can_be_simulated(log, axis, loop):
                axis = axis if fit.lag is None else replace(axis, lag=fit.lag)
                parts = (
                    Stretch.of(log, axis, loop, part) for part in log.segments or (slice(None),)
                )
                stretches += [stretch for stretch in parts if stretch.count > START_SAMPLES]
        members = min(
            max(SIMULATED // max(sum(stretch.count for stretch in stretches), 1), FEW), MANY
        )
        # A plant or friction that needs another channel is not simulated, and not predicted either.
        with suppress(InputError):
            excesses = [np.zeros(0)]
            for stretch in stretches:
                dressed = with_presliding(fit.friction, stretch.axis.presliding or 0.0)
                course = stretch.run(fit.plant, dressed, np.zeros(stretch.count))
                spread, _ = _squares(bands, fit.plant, dressed, course, stretch, members)
                residual = stretch.position[: course.position.size] - course.position
                # Excess of the squared residual over the spread and the rounding; where all other simulations diverged, the band
                # contains every sample.
                excesses.append((residual / NORMAL_95) ** 2 - spread - _rounding(stretch) ** 2)
            squares = np.concatenate(excesses)
            found |= (
                {name: max(float(np.quantile(squares, 0.95, method="higher")), 0.0) ** 0.5}
                if squares.size
                else {}
            )
    return replace(fit, resampling=replace(fit.resampling, bands=replace(bands, **found)))


def _rounding(stretch: Stretch) -> float:
    return ROUNDING * (stretch.axis.resolution or 0.0)


def _squares(
    bands: Bands, plant: Model, friction: Model, predicted: Course, stretch: Stretch, most: int
) -> np.ndarray:
    """Return the mean square deviation of other simulations in position and effort, shape (2, sample)."""
    count, dt, rng = predicted.position.size, stretch.log.sample_time, np.random.default_rng(SEED)
    # The half-cycle of each sample of the log, and the friction force there.
    log, resolution = stretch.log, stretch.axis.resolution or 0.0
    segment, noise, _ = segment_of(log, stretch.samples, CUTOFF_SHARE / dt, resolution)
    changes = reversals(segment.velocity, sided=True).tolist()
    cycle = numbered(
        turning_points(segment.position, least_way(resolution, noise), changes),
        segment.position.size,
    )
    force = along(friction, dt=dt, **segment.signals(dt, transmitted_by(friction, plant, segment)))
    block = (np.arange(cycle.size) * dt / max(bands.lasting, dt)).astype(int)

    def member(index: int, level: np.ndarray, left: np.ndarray) -> np.ndarray:
        mine = with_parameters(bands, index, plant), with_parameters(bands, index, friction)
        trial = stretch.run(
            *mine, bands.scatter * level[cycle] * force + bands.unexplained * left[block]
        )
        off = np.full((2, count), np.nan)
        reached = min(trial.position.size, count)
        off[0, :reached] = trial.position[:reached] - predicted.position[:reached]
        off[1, :reached] = trial.command[:reached] - predicted.command[:reached]
        return off * off

    members = range(min(bands.count, most))
    levels, left = (
        rng.standard_normal((len(members), int(numbers[-1]) + 1)) for numbers in (cycle, block)
    )
    with Abreast() as pool:
        squares = np.array(list(pool.map(member, members, levels, left)))
    # The mean over the simulations that reached the sample.
    finite = np.isfinite(squares)
    total, came = np.sum(squares, axis=0, where=finite), finite.sum(axis=0)
    return np.divide(total, came, out=np.full(total.shape, np.inf), where=came > 0)


MEMBERS = 40
SEED = 95


def half_width(bands: Bands, plant: Model, friction: Model, dataset: Dataset) -> np.ndarray:
    """Return the half-width of the 95 % band around the effort of each row [N or N*m]; without draws, parameters are fixed.

    Draws that diverge are left out; InputError if most diverge.
    """
    members = _efforts(bands, plant, friction, dataset, MEMBERS)
    drawn, members = len(members), [member for member in members if np.all(np.isfinite(member))]
    if 2 * len(members) < drawn:
        raise InputError(
            f"diverges with {drawn - len(members)} of {drawn} draws of its parameters",
            path="model",
            value=friction.name,
            mend="Fit another model to this log",
        )
    spread = np.var(members, axis=0, ddof=1) if len(members) > 1 else np.zeros(dataset.time.size)
    in_rows = bands.noise**2 * min(2.0 * dataset.bandwidth * dataset.sample_time, 1.0)
    return NORMAL_95 * bands.inflation * np.sqrt(spread + in_rows + bands.unexplained**2)


def _efforts(
    bands: Bands, plant: Model, friction: Model, dataset: Dataset, most: int
) -> list[np.ndarray]:
    """Return the effort of each row with the parameters of the first draws, at most `most` times [N or N*m]."""
    starts, rng = half_cycle_starts(dataset), np.random.default_rng(SEED)
    members = list[np.ndarray]()
    for body, contact in zip(bands.models(plant, most), bands.models(friction, most), strict=True):
        efforts = list[np.ndarray]()
        for segment, turns in zip(dataset.segments, starts, strict=True):
            transmitted = transmitted_by(contact, body, segment)
            force = force_with_scatter(
                contact, segment, turns, dataset.sample_time, bands.scatter, rng, transmitted
            )
            efforts.append(mechanical(body, segment) + dataset.filtered(force))
        members.append(dataset.rows_of(efforts))
    return members


def within_the_log(fit: Fit, dataset: Dataset) -> Fit:
    """Return a fit whose draws describe its log: one that is off by more than the error of the fit moves towards their centre."""
    # Draws leave the valley of a fit along straight lines. Where it bends, they contradict the log.
    if fit.resampling is None:
        return fit
    bands = fit.resampling.bands
    values = {**fit.plant.values, **fit.friction.values}
    values = {
        name: values[name] for name in bands.draws if np.all(np.isfinite(values.get(name, np.inf)))
    }
    if any(np.shape(value) != bands.draws[name].shape[1:] for name, value in values.items()):
        return fit  # each draw has elements of its own, which lie on no line through the fit
    # The middle of the draws is free of a bias of the fit: it is the centre if it describes the log about as well.
    pairs = {
        name: np.array([value, np.median(bands.draws[name], axis=0)])
        for name, value in values.items()
    }
    of_fit, of_middle = _efforts(
        replace(bands, draws=pairs, scatter=0.0), fit.plant, fit.friction, dataset, 2
    )
    error = max(np.mean(fit.traces.residual**2), np.finfo(float).tiny)
    centre = int(np.mean((of_middle - of_fit) ** 2) <= 4.0 * error)  # twice the error of the fit
    drawn = np.array(
        _efforts(replace(bands, scatter=0.0), fit.plant, fit.friction, dataset, bands.count)
    )
    # A draw that diverges stays as it is; a prediction leaves it out.
    off = np.nan_to_num(
        np.mean((drawn - (of_fit, of_middle)[centre]) ** 2, axis=1) / error, posinf=0.0
    )
    moved = {
        name: pair[centre]
        + ((bands.draws[name][: off.size] - pair[centre]).T / np.sqrt(np.maximum(off, 1.0))).T
        for name, pair in pairs.items()
    }
    return replace(
        fit,
        resampling=replace(fit.resampling, bands=replace(bands, draws={**bands.draws, **moved})),
    )
