"""Micro-damping: a chirp of small amplitude through the frequency at which the mass moves on the contact."""

from __future__ import annotations

import math

from bristle.excitation.limits import MotionLimits
from bristle.excitation.motion import ExcitationPiece
from bristle.excitation.presliding import missing as missing_for_presliding
from bristle.references import chirp

__all__ = ["missing", "pieces"]

AMPLITUDE = 0.2  # of the pre-sliding amplitude: small, so that stiffness and damping show, and not slip
COUNTS = 2.0  # of the encoder: no smaller amplitude
BELOW, ABOVE = 1.0 / 8.0, 2.5  # of the resonance
SAMPLES = 5.0  # in a period, at least
ENOUGH = 1.25  # times the resonance, that the chirp must reach
RAMP_PERIODS = 2.0  # of the lowest frequency
RAMP_SHARE = 0.2  # of the duration, at most
REST = 0.2  # [s]


def missing(limits: MotionLimits) -> str:
    """Return why there is no such motion on this axis, and what to do; nothing where there is one."""
    reason = missing_for_presliding(limits)
    if reason:
        return reason
    if limits.resonance is None:
        return (
            "the frequency at which the mass moves on the contact is not known: write the moving mass under [plant] "
            "and limit under [effort], or give a model"
        )
    if _highest(limits) < ENOUGH * limits.resonance:
        return f"the sample time of {limits.in_unit(limits.sample_time, 'time')} is too long for a resonance at {limits.resonance:.3g} Hz"
    amplitude = _amplitude(limits)
    if amplitude < COUNTS * limits.count:
        return (
            f"the limits leave it {limits.in_unit(amplitude, 'length')} at {_highest(limits):.3g} Hz, and the encoder "
            f"sees no less than {COUNTS:.0f} of its steps of {limits.in_unit(limits.count, 'length')}: raise jerk or "
            "acceleration under [limits] for this motion"
        )
    return ""


def pieces(limits: MotionLimits, seconds: float) -> list[ExcitationPiece]:
    """Return the motion, to last about so long [s]."""
    assert limits.presliding is not None
    assert limits.resonance is not None
    low, high = BELOW * limits.resonance, _highest(limits)
    omega, amplitude = 2.0 * math.pi * high, _amplitude(limits)
    duration = max(seconds - REST, 2.0 * RAMP_PERIODS / low)
    ramp = min(RAMP_PERIODS / low, RAMP_SHARE * duration)
    reference = chirp(kind=limits.kind, amplitude=amplitude, f_0=low, f_1=high, duration=duration, ramp=ramp)
    return [ExcitationPiece("damping", "chirp", reference, REST, omega * amplitude, amplitude)]


def _amplitude(limits: MotionLimits) -> float:
    """Return the amplitude of the chirp [m or rad], as large as the limits leave it."""
    assert limits.presliding is not None
    omega = 2.0 * math.pi * _highest(limits)
    # The ramps add little to what the sine itself takes.
    wanted = max(AMPLITUDE * limits.presliding, COUNTS * limits.count)
    most = (limits.velocity or math.inf) / omega, (limits.acceleration or math.inf) / omega**2, limits.jerk / omega**3
    return min(wanted, *most)


def _highest(limits: MotionLimits) -> float:
    """Return the highest frequency [Hz]."""
    return min(ABOVE * (limits.resonance or 0.0), 1.0 / (SAMPLES * limits.sample_time))
