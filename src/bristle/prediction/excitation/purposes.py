"""Six kinds of experiment: their information, their requirements, and their pieces of motion.

`presliding` has a conditioning slide, decaying loops, and pairs of triangles of increasing size: the slide and the loops
bring the contact into a known state. `break-away` reverses from rest at several rates, in both directions, until friction
has saturated. `damping` is a chirp of small amplitude through the resonance of the mass on the contact, and `stiffness` has
such chirps of rising amplitude. `stribeck` moves to and fro at constant velocities, from creeping to the largest velocity.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from bristle.models.references import chirp, s_curve, triangle
from bristle.prediction.excitation.limits import MARGIN, MotionLimits
from bristle.prediction.excitation.motion import ExcitationPiece, in_time
from bristle.prediction.excitation.swept_slide import swept_slide

REST = 0.2  # before a piece [s]
SLIDING = 5.0  # times the pre-sliding amplitude: smallest slide or reversal

SMALLEST = 0.1  # loop, of the pre-sliding amplitude
LARGEST = 0.97  # loop, of the pre-sliding amplitude
LOOP_COUNTS = 3.0  # of the encoder: smallest loop
SLIDE = 4.0  # times the pre-sliding amplitude: friction saturates much earlier
DECAYING_CYCLES = 5

RATES = (1.0, 4.0, 16.0)  # of break-away, relative to the slowest

SPEEDS = 10
SPREAD = 3.0  # smallest ratio of the largest to the smallest velocity

CHIRP_COUNTS = 2.0  # of the encoder: smallest amplitude
# Chirps for the stiffness: their number, smallest and usual ratio of the largest amplitude to the smallest.
SIZES = (5, 2.0, 8.0)
CHIRPED = (1.0 / 8.0, 2.5)  # of the resonance

LEGS = 4  # fewest legs of a slide with a sine
LONGEST_LEG = 8.0  # of a slide with a sine [s]
SWEPT = (3.0, 400.0)  # frequencies of the sine [Hz]
OF_RATE = 0.25  # highest frequency over the sampling frequency
SHAKEN = 0.5  # of the speed of a slide: largest velocity of the sine

RETURN = 1.0  # duration of the move back to the start [s]
ROUNDING = 1e-9  # of all amplitudes: smaller distances from the start are rounding


class Purpose(NamedTuple):
    """One kind of experiment: its information, its share of the time, reasons against it, its pieces, and whether only on request."""

    tells: str
    share: float
    missing: Callable[[MotionLimits], str]
    pieces: Callable[[MotionLimits, float], list[ExcitationPiece]]
    on_request: bool = False


def _no_presliding(limits: MotionLimits) -> str:
    """Return the reason why an axis does not allow this motion, with advice; empty if it does."""
    if limits.presliding is None:
        return "the pre-sliding distance is unknown. Write presliding under [plant], or give a model. A slow reversal shows this distance"
    if LOOP_COUNTS * limits.count > 0.5 * LARGEST * limits.presliding:
        return (
            f"the encoder is too coarse ({LOOP_COUNTS:.0f} steps of {limits.in_unit(limits.count, 'length')} are not "
            f"small against the pre-sliding amplitude of {limits.in_unit(limits.presliding, 'length')}). Record a finer encoder, and "
            "write its resolution under [encoder]"
        )
    if limits.followed > 0.5 * LARGEST * limits.presliding:
        mend = "Raise the gains of the controller for this motion"
        if not limits.integral:
            mend += ", or add integral action"
        return (
            f"the tracking error of the controller is {limits.in_unit(limits.followed, 'length')}, which is not small "
            f"against the pre-sliding amplitude of {limits.in_unit(limits.presliding, 'length')}. {mend}"
        )
    if limits.travel is not None and limits.travel < 2.0 * SLIDE * limits.presliding:
        return f"this motion needs a travel of {limits.in_unit(2.0 * SLIDE * limits.presliding, 'length')}. Raise the stroke or the travel"
    return ""


def _conditioning(limits: MotionLimits, purpose: str) -> ExcitationPiece:
    """Return a slide to and fro that erases the memory of the contact."""
    amplitude = SLIDE * limits.reach
    # It takes 1.5 s.
    return _triangle(limits, purpose, "conditioning slide", amplitude, 4.0 * amplitude / 1.5)


def _presliding(limits: MotionLimits, seconds: float) -> list[ExcitationPiece]:
    """Return the motion, of about this duration [s]."""
    largest = LARGEST * limits.reach
    smallest = max(SMALLEST * limits.reach, LOOP_COUNTS * limits.count, limits.followed)
    # Evenly spaced: most of the time belongs to the large loops, which contain most of the force.
    amplitudes = np.linspace(smallest, largest, 14)
    # Longest leg of 5 s: in longer legs, drift of the axis looks like friction.
    slowest = 2.0 * largest / 5.0
    # Samples in the shortest leg.
    fastest = min(2.0 * smallest / (25.0 * limits.sample_time), limits.fastest)
    cycles = 2

    def make(speed: float) -> list[ExcitationPiece]:
        decay = 0.15 ** (1.0 / (2 * DECAYING_CYCLES - 1))
        loops = _triangle(
            limits, "presliding", "decaying loops", largest, speed, DECAYING_CYCLES, decay
        )
        pairs = [
            _triangle(limits, "presliding", "triangles", amplitude, speed, cycles)
            for amplitude in amplitudes
        ]
        return [_conditioning(limits, "presliding"), loops, *pairs]

    planned = in_time(make, seconds, slowest, 1e-3 * slowest, fastest)
    if planned[-1].speed < slowest <= limits.fastest:
        cycles = 2 * max(round(slowest / planned[-1].speed), 1)
        planned = in_time(make, seconds, slowest, 1e-3 * slowest, fastest)
    return planned


def _triangle(
    limits: MotionLimits,
    purpose: str,
    name: str,
    amplitude: float,
    speed: float,
    cycles: int = 1,
    ratio: float = 1.0,
    leg: float | None = None,
) -> ExcitationPiece:
    speed = min(speed, limits.fastest)
    if not leg:
        leg = 2.0 * amplitude * ratio ** (2 * cycles - 1)  # the shortest leg
    reference = triangle(
        kind=limits.kind,
        amplitude=amplitude,
        velocity=speed,
        cycle_count=cycles,
        ratio=ratio,
        acceleration=limits.corner(speed, leg),
        jerk=limits.jerk,
    )
    return ExcitationPiece(purpose, name, reference, REST, speed, amplitude)


def _break_away(limits: MotionLimits, seconds: float) -> list[ExcitationPiece]:
    """Return the motion, of about this duration [s]."""
    turn = 2.0 * limits.reach
    most = min(turn / (50.0 * limits.sample_time), limits.fastest)

    # The conditioning slide ends forward: the first ramp reverses.
    def make(speed: float) -> list[ExcitationPiece]:
        return [
            _conditioning(limits, "break-away"),
            *(
                _ramp(limits, side, min(rate * speed, most))
                for rate in RATES
                for side in (-1.0, 1.0)
            ),
        ]

    pace = turn / (0.2 * seconds)
    return in_time(make, seconds, pace, 1e-2 * pace, most)


def _ramp(limits: MotionLimits, side: float, speed: float) -> ExcitationPiece:
    distance = SLIDING * limits.reach
    reference = s_curve(
        kind=limits.kind,
        distance=side * distance,
        velocity=speed,
        acceleration=limits.corner(speed, limits.reach),
        jerk=limits.jerk,
    )
    return ExcitationPiece(
        "break-away", "break-away ramp", reference, 2.0 * REST, speed, side * distance
    )


def closing(limits: MotionLimits, pieces: Sequence[ExcitationPiece]) -> list[ExcitationPiece]:
    """Return the piece from the end of other pieces back to their start; an empty list if they end at their start."""
    distance = -sum(piece.end for piece in pieces)
    if abs(distance) <= ROUNDING * sum(abs(piece.amplitude) for piece in pieces):
        return []
    speed = min(abs(distance) / RETURN, limits.fastest)
    acceleration = limits.corner(speed, abs(distance))
    reference = s_curve(
        kind=limits.kind,
        distance=distance,
        velocity=speed,
        acceleration=acceleration,
        jerk=limits.jerk,
    )
    return [
        ExcitationPiece(pieces[-1].purpose, "return to the start", reference, REST, speed, distance)
    ]


def _unknown(limits: MotionLimits) -> str:
    """Return the limit that a long slide needs and that is unknown, with advice; empty if all are known."""
    limited = (
        (limits.velocity, "velocity", "velocity under [limits]"),
        (
            limits.acceleration,
            "acceleration",
            "acceleration under [limits], or limit under [effort] and the moving mass",
        ),
        (limits.travel, "travel", "stroke under [limits], or give a travel"),
    )
    unknown = {quantity: remedy for value, quantity, remedy in limited if value is None}
    return (
        bool(unknown)
        * f"the {' and '.join(unknown)} limit of the axis is unknown. Write {'; write '.join(unknown.values())}"
    )


def _no_stribeck(limits: MotionLimits) -> str:
    """Return the reason why an axis does not allow this motion, with advice; empty if it does."""
    reason = _unknown(limits)
    if reason:
        return reason
    if _slowest(limits, math.inf) * SPREAD > _fastest(limits):
        return f"a travel of {limits.in_unit(limits.extent, 'length')} is too short for several velocities. Raise the stroke or the travel"
    return ""


def _stribeck(limits: MotionLimits, seconds: float) -> list[ExcitationPiece]:
    """Return the motion, of about this duration [s]."""
    acceleration = limits.largest_acceleration
    most = 0.5 * limits.extent
    fastest = _fastest(limits)
    least = _shortest(limits)

    def make(rate: float) -> list[ExcitationPiece]:
        slowest = min(_slowest(limits, seconds, rate), fastest / SPREAD)
        sweeps = []
        for speed in np.geomspace(slowest, fastest, SPEEDS):
            braking = speed * speed / acceleration + speed * acceleration / limits.jerk
            ideal = speed / (4.0 * rate)
            amplitude = min(max(ideal, least, 2.0 * braking), most)
            shape = (float(amplitude), float(speed), min(max(round(ideal / amplitude), 1), 6))
            sweeps.append(
                _triangle(limits, "stribeck", "constant velocity", *shape, leg=float(amplitude))
            )
        return sweeps

    pace = SPEEDS / seconds
    return in_time(make, seconds, pace, 1e-2 * pace, 1e3 * pace)


def _shortest(limits: MotionLimits) -> float:
    """Return the amplitude of the shortest slide [m or rad]."""
    smallest = max(SLIDING * limits.reach, 200.0 * limits.count)
    return min(smallest or 0.01 * limits.extent, 0.5 * limits.extent)


def _slowest(limits: MotionLimits, seconds: float, rate: float = 0.0) -> float:
    """Return the smallest velocity of a slide of sufficient duration [m/s or rad/s]."""
    least = 4.0 * _shortest(limits)
    if limits.stribeck_velocity is not None:
        return max(0.2 * limits.stribeck_velocity, least / (0.3 * seconds))
    return least * rate


def _fastest(limits: MotionLimits) -> float:
    """Return the largest velocity at which half of a quarter of the loop remains for a steady slide [m/s or rad/s]."""
    a = limits.largest_acceleration
    room_left = 0.25 * limits.extent
    rise = a / limits.jerk
    return min(
        limits.fastest, 2.0 * room_left / (math.sqrt(rise * rise + 4.0 * room_left / a) + rise)
    )


def _no_damping(limits: MotionLimits) -> str:
    """Return the reason why an axis does not allow this motion, with advice; empty if it does."""
    reason = _no_presliding(limits)
    if reason:
        return reason
    if limits.resonance is None:
        return (
            "the resonance of the mass on the contact is unknown. Write the moving mass under [plant] "
            "and limit under [effort], or give a model"
        )
    if _highest_frequency(limits) < 1.25 * limits.resonance:
        return (
            f"the sample time of {limits.in_unit(limits.sample_time, 'time')} is too long for a resonance at {limits.resonance:.3g} Hz. "
            "Record at a higher rate, and write sample_time under [timing]"
        )
    amplitude = _chirp_amplitude(limits)
    if amplitude < CHIRP_COUNTS * limits.count:
        return (
            f"the limits allow an amplitude of {limits.in_unit(amplitude, 'length')} at {_highest_frequency(limits):.3g} Hz, but "
            f"the amplitude must be {CHIRP_COUNTS:.0f} steps of the encoder, each {limits.in_unit(limits.count, 'length')}. Raise "
            f"{_too_low(limits)} under [limits] for this motion"
        )
    return ""


def _damping(limits: MotionLimits, seconds: float) -> list[ExcitationPiece]:
    """Return the motion, of about this duration [s]."""
    return [_chirp(limits, "damping", seconds, _chirp_amplitude(limits))]


def _chirp(limits: MotionLimits, purpose: str, seconds: float, amplitude: float) -> ExcitationPiece:
    low = CHIRPED[0] * (limits.resonance or 0.0)
    high = _highest_frequency(limits)
    duration = max(seconds - REST, 4.0 / low)
    ramp = min(2.0 / low, 0.2 * duration)
    reference = chirp(
        kind=limits.kind, amplitude=amplitude, f_0=low, f_1=high, duration=duration, ramp=ramp
    )
    return ExcitationPiece(
        purpose, "chirp", reference, REST, 2.0 * math.pi * high * amplitude, amplitude
    )


def _no_stiffness(limits: MotionLimits) -> str:
    """Return the reason why an axis does not allow this motion, with advice; empty if it does."""
    reason = _no_damping(limits)
    if reason:
        return reason
    amplitude = _chirp_amplitude(limits)
    if amplitude < SIZES[1] * CHIRP_COUNTS * limits.count:
        return (
            f"the encoder is too coarse for several amplitudes up to {limits.in_unit(amplitude, 'length')} "
            f"(its step is {limits.in_unit(limits.count, 'length')}). Record a finer encoder, and write its resolution under [encoder]"
        )
    return ""


def _stiffness(limits: MotionLimits, seconds: float) -> list[ExcitationPiece]:
    """Return the motion, of about this duration [s]."""
    count, _, ratio = SIZES
    largest = _chirp_amplitude(limits)
    smallest = max(CHIRP_COUNTS * limits.count, largest / ratio)
    return [
        _chirp(limits, "stiffness", seconds / count, float(amplitude))
        for amplitude in np.geomspace(smallest, largest, count)
    ]


def _chirp_amplitude(limits: MotionLimits) -> float:
    """Return the amplitude of the chirp [m or rad], as large as the limits allow."""
    omega = 2.0 * math.pi * _highest_frequency(limits)
    # The ramps add little to the amplitude of the sine.
    # Small against the pre-sliding amplitude, so that stiffness and damping show instead of slip.
    amplitude = max(0.2 * limits.reach, CHIRP_COUNTS * limits.count)
    most = limits.fastest / omega, limits.largest_acceleration / omega**2, limits.jerk / omega**3
    return min(amplitude, *most)


def _too_low(limits: MotionLimits) -> str:
    """Return the limits that allow no chirp of two encoder steps, with the values that do."""
    omega = 2.0 * math.pi * _highest_frequency(limits)
    limited = enumerate(
        (
            ("velocity", limits.velocity),
            ("acceleration", limits.acceleration),
            ("jerk", limits.jerk),
        ),
        1,
    )
    # Only a share of a limit is used; its square leaves some spare.
    return " and ".join(
        f"{name} to {limits.in_unit(least / MARGIN**2, f'length/time^{power}')}"
        for power, (name, usable) in limited
        if usable is not None and usable < (least := omega**power * CHIRP_COUNTS * limits.count)
    )


def _highest_frequency(limits: MotionLimits) -> float:
    """Return the highest frequency [Hz]."""
    return min(CHIRPED[1] * (limits.resonance or 0.0), 1.0 / (5.0 * limits.sample_time))


def _no_resonance(limits: MotionLimits) -> str:
    """Return the reason why an axis does not allow this motion, with advice; empty if it does."""
    reason = _unknown(limits)
    if reason:
        return reason
    if _highest_swept(limits) < 4.0 * SWEPT[0]:
        return f"the sample time of {limits.in_unit(limits.sample_time, 'time')} is too long for a resonance. Record at a higher rate"
    if SHAKEN * _resonance(limits, 2.0 * LEGS)[0].speed < 100.0 * limits.count:
        return f"a travel of {limits.in_unit(limits.extent, 'length')} is too short for long slides. Raise the stroke or the travel"
    return ""


def _resonance(limits: MotionLimits, seconds: float) -> list[ExcitationPiece]:
    """Return the motion, of about this duration [s]."""
    legs = max(LEGS, 2 * math.ceil(0.5 * seconds / LONGEST_LEG))
    # Both ends of the motion are half legs.
    time = (seconds - REST) / (legs + 1)
    speed = min(limits.extent / time, limits.fastest / (1.0 + SHAKEN))
    amplitude = 0.5 * speed * time
    reference = swept_slide(
        kind=limits.kind,
        amplitude=amplitude,
        velocity=speed,
        acceleration=MARGIN * limits.largest_acceleration,
        shaking=SHAKEN * speed,
        f_0=SWEPT[0],
        f_1=_highest_swept(limits),
        jerk=limits.jerk,
        leg_count=legs,
    )
    return [
        ExcitationPiece(
            "resonance", "swept slide", reference, REST, (1.0 + SHAKEN) * speed, amplitude
        )
    ]


def _highest_swept(limits: MotionLimits) -> float:
    """Return the highest frequency of the sine on a slide [Hz]."""
    return min(SWEPT[1], OF_RATE / limits.sample_time)


PURPOSES: dict[str, Purpose] = {
    "presliding": Purpose(
        "stiffness and loops before sliding, F_C", 0.55, _no_presliding, _presliding
    ),
    "break-away": Purpose(
        "break-away force and distance, and their dependence on the rate",
        0.12,
        _no_presliding,
        _break_away,
    ),
    "damping": Purpose(
        "micro-damping and the resonance on the contact", 0.08, _no_damping, _damping
    ),
    "stiffness": Purpose(
        "stiffness and damping of the contact without a friction model",
        0.25,
        _no_stiffness,
        _stiffness,
        on_request=True,
    ),
    "stribeck": Purpose(
        "friction over velocity, and the moving mass", 0.25, _no_stribeck, _stribeck
    ),
    "resonance": Purpose(
        "antiresonance and resonance of an elastic coupling, and both masses",
        0.25,
        _no_resonance,
        _resonance,
        on_request=True,
    ),
}
"""Purposes of a motion, by name."""
