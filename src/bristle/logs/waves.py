"""Waves over the position in a residual: cogging, a screw, a belt."""

import numpy as np

TURNS_LEAST = 1.5  # over the range
BINS = 8192  # of the position
PADDED = 4  # times: resolves quarters of a turn
HIGHEST = 2  # peaks to refine
FINER = 13  # frequencies around each
REACH = 0.6  # turns over the range to either side of it
CLEARED = 4  # quarters of a turn around a peak that belong to it
SMALL = 1e-6


def waves(x: np.ndarray, side: np.ndarray | None, frequency: float) -> np.ndarray:
    """Return cosine and sine of a frequency [1/m or 1/rad], also by the side of motion if given, shape (row, 2 or 4)."""
    phase = 2.0 * np.pi * frequency * x
    pair = np.column_stack([np.cos(phase), np.sin(phase)])
    return pair if side is None else np.hstack([pair, side[:, None] * pair])


def frequency_in(
    x: np.ndarray,
    side: np.ndarray | None,
    residual: np.ndarray,
    most: float,
    least: float = TURNS_LEAST,
) -> float | None:
    """Return the frequency [1/m or 1/rad] of the strongest waves, with `least` to `most` turns; None in a short range."""
    stroke = float(np.ptp(x))
    most = min(most, BINS / 2.0)
    if stroke <= 0.0 or most < least:
        return None
    place = ((x - x.min()) / stroke * (BINS - 1)).astype(int)
    power = sum(
        np.abs(np.fft.rfft(np.bincount(place, weights=signal, minlength=BINS), PADDED * BINS)) ** 2
        for signal in (residual, *(() if side is None else (side * residual,)))
    )
    turns = np.arange(PADDED * BINS // 2 + 1) / PADDED
    power = np.where((turns >= least) & (turns <= most), power, 0.0)
    best = (-1.0, 0.0)
    for _ in range(HIGHEST):
        peak = int(np.argmax(power))
        for near in turns[peak] + np.linspace(-REACH, REACH, FINER):
            frequency = max(float(near), 0.5) / stroke
            best = max(best, (_explained(x, side, residual, frequency), frequency))
        power[max(peak - CLEARED, 0) : peak + CLEARED + 1] = 0.0
    return best[1]


def _explained(
    x: np.ndarray, side: np.ndarray | None, residual: np.ndarray, frequency: float
) -> float:
    """Return the sum of squares of a residual explained by waves of a frequency, beyond a constant for each side."""
    columns = np.column_stack(
        [waves(x, side, frequency), np.ones_like(x), *(() if side is None else (side,))]
    )
    gram, right = columns.T @ columns, columns.T @ residual
    return float(
        right @ np.linalg.solve(gram + (SMALL * float(np.trace(gram)) * np.eye(right.size)), right)
    )
