"""What the identification of a hysteresis operator returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle.core.contracts import Model
from bristle.core.diagnostic import HeldOut
from bristle.engine import response
from bristle.hysteresis.identification.curves import Congruency
from bristle.logs.curves import Curves


@dataclass(frozen=True)
class OperatorPrediction:
    """What an operator says of recorded hysteresis.

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
        Constant output beside the operator, in the unit of the output; operators with an offset of their own have 0.
    prediction : OperatorPrediction
        The operator on the curves that it was fitted to.
    held_out : HeldOut or None
        Error on curves, or blocks of samples, that were not fitted, over full scale [%].
    notes : tuple of str
        What was found on the way.
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
        """Numbers that say how good the fit is."""
        metrics = {"error_percent": self.prediction.error_percent, "rmse": self.prediction.rmse}
        if self.held_out is not None:
            metrics["held_out_error_percent"] = self.held_out.mean_percent
            metrics["held_out_error_std_percent"] = self.held_out.std_percent
        return metrics


@dataclass(frozen=True)
class OperatorIdentification:
    """Every operator fitted to the same hysteresis, best first, and whether such an operator can be adequate.

    Parameters
    ----------
    fits : tuple of OperatorFit
        In the order of the error on what was not fitted.
    recorded : Curves
        The data.
    congruency : Congruency
        By how much branches differ that an operator has alike.
    unfinished : str
        What a person who interrupted the work left undone; empty where all was done.
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
        """What was found, each once, with the operators that it is said of."""
        fits_by_note: dict[str, list[str]] = {}
        for fit in self.fits:
            for note in fit.notes:
                fits_by_note.setdefault(note, []).append(fit.name)
        return tuple(f"{', '.join(names)}: {note}" for note, names in fits_by_note.items())


def predict_operator(operator: Model, recorded: Curves, offset: float = 0.0) -> OperatorPrediction:
    """Return what an operator says of recorded hysteresis.

    Parameters
    ----------
    operator : Model
        A hysteresis operator with parameters.
    recorded : Curves
        Input and output; each curve begins anew.
    offset : float
        Constant output beside the operator.
    """
    outputs = tuple(response(operator, curve.u, history=recorded.history(curve)) + offset for curve in recorded.curves)
    error = np.concatenate([output - curve.f for output, curve in zip(outputs, recorded.curves, strict=True)])
    return OperatorPrediction(outputs, float(np.sqrt(np.mean(error**2))), recorded.full_scale)
