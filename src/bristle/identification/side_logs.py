r"""Logs of either side of an elastic coupling, each of an axis with one mass.

With two encoders, the force of the coupling follows from its deflection. A sensor of torque or force between motor and nut
measures the force :math:`T` that enters the load side. It separates both sides without stiffness and play:

.. math:: u(t + \tau_u) - T(t + \tau_T) = m_1 \ddot x_1 + F_1, \qquad T(t + \tau_T) = m_s \ddot x_1 + c_T |f_s|\, z + m_2 \ddot x_2 + F_2 .

The sensor is the effort of the axis behind it. Motor of this axis is the mass :math:`m_s` between sensor and coupling, such as
a screw.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bristle.core.axis import COUPLING_EFFORT, LOAD_ENCODER
from bristle.core.errors import InputError
from bristle.identification.dataset import effort_of
from bristle.identification.elasticity import M_1, Masses
from bristle.identification.lost_motion import LostMotion
from bristle.identification.two_encoders import DELAY_STEP, EARLY, LATE, TINY, Record
from bristle.logs.filters import ahead, derivative, low_passed
from bristle.logs.log import Channel, Log

ALIKE = 0.05  # allowed difference of the strokes of motor and load, as a share
CUTOFF, HIGHEST = 0.2, 200.0  # of the sampling frequency; Hz: for the rate of the coupling
SLOW, LEAST, MOST = 3.0, 0.01, 1.3  # Hz, below which a sensor measures these shares of the effort
MOSTLY = 0.8  # of the squared twist: share by which one signal is its likely cause
SIGN, FADED = 0.01, 0.1  # of the top speed: width of the sign, speed at which friction has faded


def records_of(log: Log) -> list[Record]:
    """Return the stretches of a log without a gap; both encoders begin at the same place."""
    records = []
    for part in log.segments:
        motor, load = log.position.values[part], log.further[LOAD_ENCODER].values[part]
        strokes = motor - motor.mean(), load - load.mean()
        ratio = float(strokes[0] @ strokes[1]) / max(float(strokes[0] @ strokes[0]), TINY)
        if abs(ratio - 1.0) > ALIKE:
            raise InputError(
                "moves otherwise than the motor",
                path=f"columns.{LOAD_ENCODER}",
                value=f"{ratio:.3g} times as far",
                allowed="1",
                mend="Check unit and sign of both columns, side, gear_ratio and lead",
            )
        twist = motor - load
        low, high = np.quantile(twist, [0.005, 0.995]).tolist()
        records.append(
            Record(motor, load + 0.5 * (low + high), effort_of(log)[part], log.sample_time)
        )
    return records


def behind_sensor(log: Log) -> Log:
    """Return the log of the axis behind a sensor, which measures its effort."""
    effort, sensor = effort_of(log), log.further[COUPLING_EFFORT]
    slow = [
        low_passed(signal - signal.mean(), min(SLOW, 0.1 / log.sample_time), log.sample_time)
        for signal in (effort, sensor.values)
    ]
    share = float(slow[0] @ slow[1]) / max(float(slow[0] @ slow[0]), TINY)
    if not LEAST < share < MOST:
        place, value = f"columns.{COUPLING_EFFORT}", f"{share:.3g} times the effort"
        if share < 0.0:
            raise InputError(
                "has the opposite sign of the effort",
                path=place,
                value=value,
                mend="Write sign = -1 in its column",
            )
        raise InputError(
            "does not measure a part of the effort",
            path=place,
            value=value,
            allowed=f"{LEAST:g} to {MOST:g}",
            mend="Check unit and side of its column, and the constant of the effort",
        )
    return replace(log, effort=sensor)


def effort_delay(logs: Sequence[Log], sensor_delay: float) -> float:
    """Return the delay [s] at which mass and friction explain most of the effort, without that behind a sensor."""
    delays = np.arange(-EARLY, LATE, DELAY_STEP)
    squares = np.zeros(delays.size)
    for log, part in ((each, part) for each in logs for part in each.segments):
        dt = log.sample_time
        x, effort, sensor = (
            low_passed(signal[part], min(CUTOFF / dt, HIGHEST), dt) for signal in _signals(log)
        )
        speed = derivative(x, dt)
        top = max(float(np.quantile(np.abs(speed), 0.99)), TINY)
        side = np.tanh(speed / (SIGN * top))
        columns = np.stack(
            [
                derivative(speed, dt),
                speed,
                side,
                side * np.exp(-np.abs(speed) / (FADED * top)),
                np.ones(x.size),
            ],
            axis=1,
        )
        forces = np.stack([ahead(effort, delay / dt) for delay in delays]) - ahead(
            sensor, sensor_delay / dt
        )
        basis = np.linalg.qr(columns / np.linalg.norm(columns, axis=0))[0]
        squares += np.sum(forces**2, axis=1) - np.sum((forces @ basis) ** 2, axis=1)
    best = min(max(int(np.argmin(squares)), 1), delays.size - 2)
    bend, slope = np.polyfit([-1.0, 0.0, 1.0], squares[best - 1 : best + 2], 2)[:2].tolist()
    return float(delays[best]) + (
        DELAY_STEP * min(max(-0.5 * slope / bend, -1.0), 1.0) if bend > 0.0 else 0.0
    )


def _signals(log: Log) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position, effort, and the effort of a sensor, 0 without a sensor."""
    sensor = log.further.get(COUPLING_EFFORT)
    return (
        log.position.values,
        effort_of(log),
        np.zeros(len(log)) if sensor is None else sensor.values,
    )


def without_sensor(log: Log, sensor_delay: float, delay: float) -> Log:
    """Return the log without the effort behind a sensor, given the delays of sensor and effort [s]."""
    _, effort, sensor = _signals(log)
    moved = np.zeros(len(log))
    for part in log.segments:
        moved[part] = ahead(effort[part], delay / log.sample_time) - ahead(
            sensor[part], sensor_delay / log.sample_time
        )
    return alone(log, moved)


def alone(log: Log, effort: np.ndarray, *, load: bool = False, softness: float = 0.0) -> Log:
    """Return the log of the motor or of the load, of one mass; the `softness` of a coupling gives the load a position."""
    assert log.effort is not None
    bare = replace(log, velocity=None, reference=None, injected=(), further={}, regressors=())
    encoder, force = (
        log.further.get(LOAD_ENCODER, log.position),
        Channel(effort, log.effort.unit, log.effort.column),
    )
    position = Channel(encoder.values - softness * effort, log.position.unit, encoder.column)
    return replace(bare, position=position if load else log.position, effort=force)


def side_logs(
    log: Log, masses: Masses, lost: LostMotion, *, measured: bool = False
) -> tuple[Log, Log]:
    """Return the logs of the motor and of the load as axes with one mass; a `measured` effort is that behind a sensor."""
    pushed, pulled = np.zeros(len(log)), np.zeros(len(log))
    for part, record in zip(log.segments, records_of(log), strict=True):
        cutoff = min(CUTOFF / record.dt, HIGHEST)
        stretch = lost.dead(record.motor - record.load)
        smooth = low_passed(stretch, cutoff, record.dt)
        spring = (
            masses.stiffness * stretch
            if lost.hysteresis is None
            else lost.hysteresis.pull(smooth, record.dt)
        )
        pulled[part] = spring + masses.damping * derivative(smooth, record.dt)
        nut = lost.nut_share(record) * np.abs(pulled[part])
        pushed[part] = ahead(record.effort, masses.delay / record.dt) - pulled[part] - nut
        if measured:  # the load as the sensor shows it: without friction of the nut and the mass in front of the coupling
            speed = derivative(
                low_passed(record.motor - record.motor[0], cutoff, record.dt), record.dt
            )
            pulled[part] += pushed[part] - masses.values[M_1] * derivative(speed, record.dt)
    return alone(log, pushed), alone(log, pulled, load=True)


def advice(records: Sequence[Record]) -> str:
    """Return the likely cause why a log does not show two masses, from the signal that explains most of the twist, and its cure."""
    longest = max(records, key=lambda record: record.motor.size)
    size, dt = longest.motor.size, longest.dt
    twist, place = longest.motor - longest.load, longest.motor - longest.motor.mean()
    time = dt * np.arange(size)
    signals = np.stack(
        [
            place,
            time - time.mean(),
            np.gradient(low_passed(place, min(CUTOFF / dt, HIGHEST), dt), dt),
        ]
    )
    centred = twist - twist.mean()
    slopes = signals @ centred / np.maximum(np.sum(signals**2, axis=1), TINY)
    shares = np.array(
        [
            1.0 - rms(centred - slope * signal) ** 2 / max(rms(centred) ** 2, TINY)
            for slope, signal in zip(slopes, signals, strict=True)
        ]
    )
    best = int(np.argmax(shares))
    if shares[best] < MOSTLY:
        return (
            "Excite the axis around its antiresonance and sample both encoders at the same time. Check that `position` is the encoder "
            "of the motor, and the sign of the effort"
        )
    return (
        f"The scale moves {1.0 - slopes[0]:.5g} times as far as the motor. Correct lead or gear_ratio",
        f"The encoders drift apart by {abs(slopes[1]) * time[-1]:.2g} in the unit of the axis. Warm the axis up, or use a shorter log",
        f"The twist is mostly proportional to the velocity, like a delay of {1e3 * abs(slopes[2]):.2g} ms between the encoders. "
        "Sample both at the same time",
    )[best]


def rms(signal: np.ndarray) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(signal**2)))
