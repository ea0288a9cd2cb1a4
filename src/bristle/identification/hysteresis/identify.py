"""Identification of a hysteresis operator from recorded hysteresis, of friction or of a magnet."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from bristle.core.contracts import Model, make_model
from bristle.core.cores import cores_for_simulations
from bristle.core.diagnostic import HeldOut
from bristle.core.edge import NAMES, Progress, among, guarded, instance, whole
from bristle.core.errors import InputError
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.engine import response
from bristle.identification.hysteresis.linear import (
    RESOLUTION,
    Fitted,
    Rows,
    fit_grid,
    fit_stops,
    outputs_of,
)
from bristle.identification.hysteresis.result import (
    Congruency,
    OperatorFit,
    OperatorIdentification,
    congruency_of,
    predict_operator,
    smoothed,
)
from bristle.logs.curves import Curves
from bristle.models.hysteresis import preisach, table_of_curves
from bristle.models.hysteresis.everett import KERNELS

SAMPLES_LEAST = 20  # of a recording, for each fold


def fit_table(recorded: Curves) -> Fitted:
    """Return the table along first-order reversal curves."""
    if recorded.start != "saturated" or len(recorded.curves) < 2:
        mend = (
            'Write start = "saturated" if your curves start from saturation, or fit preisach_grid'
        )
        raise InputError(
            "needs reversal curves, which start from saturation",
            path="model",
            value="reversal_table",
            mend=mend,
        )
    behind = smoothed(recorded)
    table = table_of_curves(
        [(curve.u, curve.f) for curve in behind.recorded.curves], kind=recorded.kind
    )
    remark = f"bristle smoothed each curve over {behind.window} samples, because smoothed curves predict the neighbouring curves better"
    return Fitted(table, notes=(remark,) if behind.window > 1 else ())


@guarded(
    recorded=instance(Curves, "recorded curves", "Write read_curves(...)"),
    model=NAMES,
    stops=whole(2, 10_000),
    cells=whole(2, 100),
    folds=whole(2, 1000, none=True),
)
@cores_for_simulations()
def identify_operator(
    recorded: Curves,
    model: Any = ("all",),
    *,
    stops: int = RESOLUTION,
    cells: int = RESOLUTION,
    folds: int = 5,
    progress: Progress | None = None,
) -> OperatorIdentification:
    """Identify hysteresis operators from recorded input and output, and rank them by their held-out error.

    Parameters
    ----------
    recorded : Curves
        Input and output along one path or several, such as first-order reversal curves.
    model : str or sequence of str
        ``"prandtl_ishlinskii"``, stops with non-negative weights; ``"preisach"``, the best closed form;
        ``"preisach_grid"``, the measure of each cell, whose sign off the diagonal follows from the data;
        ``"reversal_table"``, the Everett function along the recorded curves. Separate several names by commas. The
        default, ``"all"``, fits every operator that the data allow.
    stops, cells : int
        Number of stops, and of cells along a side of the grid.
    folds : int
        Number of parts for held-out errors. If there are at least twice as many curves as parts, a part consists of
        curves, such as every fifth curve; otherwise it is a block of samples. The first and the last curve are always
        fitted. 0 skips held-out errors.
    progress : callable, optional
        Called with the share of the work done and the current task.

    Returns
    -------
    OperatorIdentification
        The operators, best first; after an interruption (Ctrl-C), those fitted so far.

    Raises
    ------
    InputError
        If there is no such operator, or the data are unsuitable.
    """
    names, fits = _names(model, recorded), []
    options = {"prandtl_ishlinskii": {"count": stops}, "preisach_grid": {"cells": cells}}
    for number, name in enumerate(names):

        def report(share: float, name: str = name, before: int = number) -> None:
            if progress is not None:
                progress((before + share) / len(names), f"fitting {name}")

        try:
            fits.append(
                _fit(name, recorded, partial(FITTED[name], **options.get(name, {})), folds, report)
            )
        except KeyboardInterrupt:
            if not fits:
                raise
            break
    missing = names[len(fits) :]
    fits.sort(
        key=lambda fit: fit.held_out.mean_percent if fit.held_out else fit.prediction.error_percent
    )
    congruency = congruency_of(recorded)
    ranked = tuple(
        replace(fit, rank=rank, notes=(*fit.notes, *_adequacy(fit, congruency)))
        for rank, fit in enumerate(fits, 1)
    )
    were = "was" if len(missing) == 1 else "were"
    unfinished = f"interrupted: {', '.join(missing)} {were} not fitted" if missing else ""
    return OperatorIdentification(ranked, recorded, congruency, unfinished)


def _names(model: Sequence[str], recorded: Curves) -> list[str]:
    requested = [among(*FITTED, "all")(name, "model", None) for name in model]
    names = [name for entry in requested for name in (FITTED if entry == "all" else [entry])]
    if tuple(names) == tuple(FITTED) and recorded.start != "saturated":
        names.remove("reversal_table")
    if not names or len(set(names)) < len(names):
        raise InputError(
            "must name operators, each once", path="model", value=model, allowed=", ".join(FITTED)
        )
    return names


def _fit(
    name: str,
    recorded: Curves,
    fit_operator: Callable[..., Fitted],
    folds: int,
    report: Callable[[float], None],
) -> OperatorFit:
    report(0.0)
    fitted = fit_operator(recorded)
    fit = OperatorFit(
        fitted.operator,
        fitted.offset,
        predict_operator(fitted.operator, recorded, fitted.offset),
        notes=fitted.notes,
    )
    by_curve = len(recorded.curves) >= 2 * folds
    if not folds or (name == "reversal_table" and not by_curve):
        return fit
    errors = []
    for fold, rmse in enumerate(
        (_without_curves if by_curve else _without_blocks)(recorded, fit_operator, folds), 2
    ):
        errors.append(100.0 * rmse / recorded.full_scale)
        report(min(fold, folds) / (folds + 1))
    return replace(
        fit, held_out=HeldOut(tuple(errors), float(np.mean(errors)), float(np.std(errors, ddof=1)))
    )


def _without_curves(
    recorded: Curves, fit_operator: Callable[..., Fitted], folds: int
) -> Iterator[float]:
    """Yield the root mean square error on every fifth curve, say, with all others fitted."""
    order = sorted(recorded.curves, key=lambda curve: float(curve.u[0]))
    for fold in range(folds):
        out = [k for k in range(1, len(order) - 1) if k % folds == fold]
        held = replace(recorded, curves=tuple(order[k] for k in out))
        fit = fit_operator(
            replace(recorded, curves=tuple(curve for k, curve in enumerate(order) if k not in out))
        )
        yield predict_operator(fit.operator, held, fit.offset).rmse


def _without_blocks(
    recorded: Curves, fit_operator: Callable[..., Fitted], folds: int
) -> Iterator[float]:
    """Yield the root mean square error on blocks of samples, with all others fitted; the memory continues through them."""
    sizes = [curve.u.size for curve in recorded.curves]
    if sum(sizes) < SAMPLES_LEAST * folds:
        most = max(sum(sizes) // SAMPLES_LEAST, 2)
        raise InputError(
            "the curves have too few samples for so many folds",
            path="folds",
            value=folds,
            allowed=f"2 to {most}, or 0",
        )
    fold_of = np.arange(sum(sizes)) * folds // sum(sizes)
    parts = np.split(fold_of, np.cumsum(sizes)[:-1])
    measured = np.concatenate([curve.f for curve in recorded.curves])
    for fold in range(folds):
        fit = fit_operator(recorded, rows=[np.flatnonzero(part != fold) for part in parts])
        predicted = np.concatenate(predict_operator(fit.operator, recorded, fit.offset).outputs)
        yield float(np.sqrt(np.mean((predicted - measured)[fold_of == fold] ** 2)))


def _adequacy(fit: OperatorFit, congruency: Congruency) -> tuple[str, ...]:
    """Return the verdict of the congruency of the data on an operator, in words."""
    limit = congruency.anywhere if fit.name == "prandtl_ishlinskii" else congruency.alike
    if limit is None:
        return ()
    difference = with_unit(limit, unit_of("force", fit.operator.kind))
    share = 100.0 * limit / fit.prediction.full_scale
    course = (
        "the shape of a branch depends on its turning point, by"
        if fit.name == "prandtl_ishlinskii"
        else "branches that turned at the same input differ by"
    )
    return (
        f"{course} {difference} ({share:.2g} % of full scale). This operator cannot follow the difference",
    )


STARTS = (0.3, 3.0, 30.0)  # of s x over f_p at the largest input


def fit_closed_form(
    recorded: Curves, *, kernels: Sequence[str] = KERNELS, rows: Rows = None
) -> Fitted:
    """Fit stiffness, saturation and exponent to recorded hysteresis, by the best of some kernels.

    Raises
    ------
    InputError
        If input or output does not move.
    """
    # Two or three parameters need only a few curves, evenly chosen.
    step = -(-len(recorded.curves) // 25)
    recorded, rows = (
        replace(recorded, curves=recorded.curves[::step]),
        None if rows is None else rows[::step],
    )
    extent, spread = max(abs(recorded.low), abs(recorded.high)), float(np.ptp(outputs_of(recorded)))
    if not (extent > 0.0 and spread > 0.0):
        raise InputError(
            f"must vary; its largest value is {extent}, and the output spans {spread}", path="input"
        )
    return min(
        (_closed_form(recorded, kernel, extent, 0.5 * spread, rows) for kernel in kernels),
        key=lambda fit: fit.rms,
    )


def _closed_form(recorded: Curves, kernel: str, extent: float, level: float, rows: Rows) -> Fitted:
    """Return least squares in the logarithms of f_p over half the range of the output, of s x/f_p, and in the exponent."""
    from scipy.optimize import least_squares

    target = outputs_of(recorded, rows)
    low, high = (
        [math.log(level_share), math.log(stiffness)]
        for level_share, stiffness in ((0.1, 1e-3), (100.0, 1e4))
    )
    if kernel == "dahl_masing":
        low, high = [*low, 0.5], [*high, 4.0]

    def operator_at(x: np.ndarray) -> Model:
        f_p = level * math.exp(x[0])
        values = {"s": f_p * math.exp(x[1]) / extent, "f_p": f_p, "kernel": kernel} | (
            {"exponent": float(x[2])} if x.size > 2 else {}
        )
        return make_model(preisach, values, kind=recorded.kind, validate=True)

    def error_at(x: np.ndarray) -> np.ndarray:
        operator = operator_at(x)
        outputs = [
            response(operator, curve.u, history=recorded.history(curve))
            for curve in recorded.curves
        ]
        return (
            np.concatenate(
                [
                    output[part]
                    for output, part in zip(
                        outputs, rows or [slice(None)] * len(outputs), strict=True
                    )
                ]
            )
            - target
        )

    def residual(x: np.ndarray) -> np.ndarray:
        error = error_at(x)
        return (error - error.mean()) / level

    start = min(
        [np.array([0.3, math.log(k), 2.0][: len(low)]) for k in STARTS],
        key=lambda x: float(np.sum(residual(x) ** 2)),
    )
    solution = least_squares(
        residual, start, bounds=(low, high), max_nfev=60, xtol=1e-9, ftol=1e-10
    )
    return Fitted(
        operator_at(solution.x),
        -float(np.mean(error_at(solution.x))),
        level * float(np.sqrt(np.mean(solution.fun**2))),
    )


FITTED: dict[str, Callable[..., Fitted]] = {
    "prandtl_ishlinskii": fit_stops,
    "preisach": fit_closed_form,
    "preisach_grid": fit_grid,
    "reversal_table": fit_table,
}
"""The operators that can be identified, and how."""
