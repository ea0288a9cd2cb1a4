"""Result of the identification of a hysteresis operator."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.diagnostic import HeldOut
from bristle.engine import response
from bristle.identification.hysteresis.linear import trace_of
from bristle.logs.curves import Curve, Curves

WINDOWS = (1, 5, 9, 13)  # samples
SHARES = np.linspace(0.0, 1.0, 101)  # of a curve, at which it is compared


class Congruency(NamedTuple):
    """Difference between recorded branches [N, N*m or A*m^2]; None without two comparable branches.

    ``alike`` is the difference of branches that turned at the same input: no Preisach operator can avoid it.
    ``anywhere`` is the difference of branches that turned far apart: no Prandtl-Ishlinskii operator can avoid it.
    """

    alike: float | None
    anywhere: float | None


class Branch(NamedTuple):
    """Path after a turning point, mirrored if necessary so that it rises."""

    turn: float
    travel: np.ndarray
    change: np.ndarray


def congruency_of(recorded: Curves) -> Congruency:
    """Return the deviation of recorded branches from congruency."""
    close, far = [], []
    # Of the range of inputs: turning points between which branches change evenly.
    nearness = 0.02 * (recorded.high - recorded.low)
    for side in (1.0, -1.0):
        branches = _branches(recorded, side)
        third = len(branches) // 3
        near = zip(branches, branches[1:], branches[2:], strict=False)
        close += [
            _difference(*three) for three in near if three[2].turn - three[0].turn <= nearness
        ]
        apart = zip(branches, branches[third:], branches[2 * third :], strict=False)
        far += [_difference(first, last, middle) for first, middle, last in apart if third]
    return Congruency(_level(close), _level(far))


def _branches(recorded: Curves, side: float) -> list[Branch]:
    """Return the branches in one direction, sorted by their turning point."""
    branches = []
    for curve in recorded.curves:
        trace = trace_of(curve.u, recorded.history(curve))
        base, rising = trace.base[trace.first :] - trace.first, trace.side[trace.first :] == side
        for turned in np.unique(base[rising & (base >= 0)]):
            part = np.flatnonzero((base == turned) & rising)
            if part.size >= 5:  # of a branch
                travel, change = (
                    side * (curve.u[part] - curve.u[turned]),
                    side * (curve.f[part] - curve.f[turned]),
                )
                branches.append(Branch(float(curve.u[turned]), travel, change))
    return sorted(branches, key=lambda branch: branch.turn)


def _difference(before: Branch, branch: Branch, behind: Branch) -> np.ndarray:
    """Return the difference of a branch from the interpolation of two others, over their common part."""
    three = (before, branch, behind)
    # Of a branch, at which it is compared.
    travel = np.linspace(0.0, min(branch.travel[-1] for branch in three), 20 + 1)[1:]
    low, inner, high = (
        np.interp(travel, [0.0, *branch.travel], [0.0, *branch.change]) for branch in three
    )
    width = behind.turn - before.turn
    share = float(np.clip((branch.turn - before.turn) / width, 0.0, 1.0)) if width > 0.0 else 0.5
    return (inner - low - share * (high - low)) / np.sqrt(1.0 + share**2 + (1.0 - share) ** 2)


def _level(differences: list[np.ndarray]) -> float | None:
    return float(np.sqrt(np.mean(np.square(differences)))) if differences else None


class Smoothed(NamedTuple):
    """Curves smoothed by a cubic over `window` samples; with 1, the recorded curves.

    Neighbouring curves share their shape, but not the noise of the output. With the chosen window, smoothed
    neighbours predict the recorded curve between them best.
    """

    recorded: Curves
    window: int


def smoothed(recorded: Curves) -> Smoothed:
    """Return reversal curves smoothed with the window that predicts neighbouring curves best."""
    order = sorted(recorded.curves, key=lambda curve: float(curve.u[0]))
    if len(order) < 3:
        return Smoothed(recorded, 1)
    raw, best, window = _rows(order), np.inf, 1
    for width in WINDOWS:
        error = _error_between(_rows([_behind(curve, width) for curve in order]), raw, order)
        if error < 0.999 * best:  # of the error, at most: a wider window must improve on it
            best, window = error, width
    return Smoothed(
        replace(recorded, curves=tuple(_behind(curve, window) for curve in recorded.curves)), window
    )


def _behind(curve: Curve, window: int) -> Curve:
    """Return a curve smoothed by the sliding cubic; a curve shorter than its window is unchanged."""
    if window == 1 or curve.f.size < window:
        return curve
    from scipy.signal import savgol_filter

    return Curve(curve.u, np.asarray(savgol_filter(curve.f, window, 3)))


def _rows(curves: list[Curve]) -> np.ndarray:
    """Return the outputs at equal shares of each curve, shape (curve, share)."""
    rows = []
    for curve in curves:
        side = 1.0 if curve.u[-1] >= curve.u[0] else -1.0
        rows.append(
            np.interp(
                side * (curve.u[0] + SHARES * (curve.u[-1] - curve.u[0])), side * curve.u, curve.f
            )
        )
    return np.array(rows)


def _error_between(rows: np.ndarray, raw: np.ndarray, curves: list[Curve]) -> float:
    """Return the root mean square error of recorded curves, predicted from their neighbours."""
    turn = np.array([float(curve.u[0]) for curve in curves])
    width = turn[2:] - turn[:-2]
    share = np.divide(
        turn[1:-1] - turn[:-2], width, out=np.full(width.size, 0.5), where=width > 0.0
    )[:, None]
    return float(np.sqrt(np.mean((raw[1:-1] - (1.0 - share) * rows[:-2] - share * rows[2:]) ** 2)))


@dataclass(frozen=True)
class OperatorPrediction:
    """Prediction of recorded hysteresis by an operator.

    Parameters
    ----------
    outputs : tuple of ndarray
        Predicted output of each curve, shape (sample,) each.
    rmse : float
        Root mean square error [N, N*m or A*m^2].
    full_scale : float
        Largest recorded output.
    """

    outputs: tuple[np.ndarray, ...]
    rmse: float
    full_scale: float

    @property
    def error_percent(self) -> float:
        """Root mean square error over full scale [%]."""
        return 100.0 * self.rmse / self.full_scale


@dataclass(frozen=True)
class OperatorFit:
    """One operator fitted to recorded hysteresis.

    Parameters
    ----------
    operator : Model
        The operator with the identified values.
    offset : float
        Constant added to the operator, in the unit of the output; 0 for operators with an ``offset`` parameter.
    prediction : OperatorPrediction
        Prediction of the fitted curves by the operator.
    held_out : HeldOut or None
        Error on held-out curves or blocks of samples, in percent of full scale [%].
    notes : tuple of str
        Remarks on the fit.
    rank : int
        1 for the best of the operators compared.
    """

    operator: Model
    offset: float
    prediction: OperatorPrediction
    held_out: HeldOut | None = None
    notes: tuple[str, ...] = ()
    rank: int = 1

    @property
    def name(self) -> str:
        """Name of the operator."""
        return self.operator.name

    @property
    def metrics(self) -> dict[str, float]:
        """Errors of the fit, by name."""
        metrics = {"error_percent": self.prediction.error_percent, "rmse": self.prediction.rmse}
        if self.held_out is not None:
            metrics["held_out_error_percent"] = self.held_out.mean_percent
            metrics["held_out_error_std_percent"] = self.held_out.std_percent
        return metrics


@dataclass(frozen=True)
class OperatorIdentification:
    """Every operator fitted to the same hysteresis, best first, and a test whether any such operator can be adequate.

    Parameters
    ----------
    fits : tuple of OperatorFit
        The fits in the order of their held-out error.
    recorded : Curves
        The data.
    congruency : Congruency
        Differences between recorded branches that every operator of a kind predicts as equal.
    unfinished : str
        Work left undone after an interruption; empty otherwise.
    """

    fits: tuple[OperatorFit, ...]
    recorded: Curves
    congruency: Congruency
    unfinished: str = ""

    @property
    def best(self) -> OperatorFit:
        """The operator of the first rank."""
        return self.fits[0]

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks, each once, with the operators that each remark refers to."""
        fits_by_note: dict[str, list[str]] = {}
        for fit in self.fits:
            for note in fit.notes:
                fits_by_note.setdefault(note, []).append(fit.name)
        return tuple(f"{', '.join(names)}: {note}" for note, names in fits_by_note.items())


def predict_operator(operator: Model, recorded: Curves, offset: float = 0.0) -> OperatorPrediction:
    """Return the prediction of recorded hysteresis by an operator.

    Parameters
    ----------
    operator : Model
        A hysteresis operator with parameters.
    recorded : Curves
        Input and output; each curve begins anew.
    offset : float
        Constant added to the operator.
    """
    outputs = tuple(
        response(operator, curve.u, history=recorded.history(curve)) + offset
        for curve in recorded.curves
    )
    error = np.concatenate(
        [output - curve.f for output, curve in zip(outputs, recorded.curves, strict=True)]
    )
    return OperatorPrediction(outputs, float(np.sqrt(np.mean(error**2))), recorded.full_scale)
