"""An identification as an estimator of scikit-learn."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from typing import Any, Self

import numpy as np

from bristle.core import Axis, FrictionModel, InputError, MissingExtraError, array
from bristle.files import AXIS
from bristle.logs import is_table
from bristle.prediction import effort_of_motion
from bristle.report.identified import identify

try:
    from sklearn.base import BaseEstimator, RegressorMixin
    from sklearn.utils.validation import check_is_fitted
except ImportError as error:
    raise MissingExtraError.of("an estimator of scikit-learn", "sklearn") from error

from bristle.identification import Settings
from bristle.report.identified import Identified

COLUMNS = ("time", "position", "velocity")


class FrictionRegressor(RegressorMixin, BaseEstimator):
    """Friction and inertia of an axis as an estimator of scikit-learn: the effort from time and position.

    `fit` checks these arguments and passes them to the arguments of `bristle.identify` with the same names.

    Parameters
    ----------
    model : str, FrictionModel, or list of either
        From a list, the best model is used.
    axis : Axis or path-like, optional
        Data of the axis. Its columns are not used, because `X` and `y` are in SI. Use ``Axis(kind="rotational")`` for a
        rotational axis.
    cutoff, decimation, blocks, offset, mass, free, draws, method, settings
        As in `bristle.identify`, except that without `draws` no logs are simulated for intervals. This simulation takes
        the most time, and cross-validation does not need it.

    Attributes
    ----------
    identified_ : Identified
        Result of `bristle.identify`: parameters, intervals, diagnostics, report.
    n_features_in_ : int
        Number of columns of `X`.
    feature_names_in_ : ndarray of str
        Names of the columns, if `X` was a data frame.

    Examples
    --------
    >>> t = np.arange(4000) * 1e-3
    >>> position = 0.02 * np.sin(3.0 * t) + 0.01 * np.sin(11.0 * t)
    >>> velocity = 0.06 * np.cos(3.0 * t) + 0.11 * np.cos(11.0 * t)
    >>> effort = 12.0 * np.gradient(velocity, t) + 5.0 * np.sign(velocity) + 80.0 * velocity
    >>> fitted = FrictionRegressor("coulomb_viscous").fit(np.column_stack((t, position)), effort)
    >>> round(fitted.identified_.parameters["M"].value, 1)
    12.0
    >>> bool(fitted.score(np.column_stack((t, position)), effort) > 0.98)
    True
    """

    def __init__(
        self,
        model: str | FrictionModel | Sequence[str | FrictionModel] = "coulomb_viscous",
        *,
        axis: Axis | str | PathLike[str] | None = None,
        cutoff: float | str | None = None,
        decimation: int | None = None,
        blocks: int | None = None,
        offset: float | str | None = None,
        mass: float | str | None = None,
        free: str | Sequence[str] = (),
        draws: int = 0,
        method: str | None = None,
        settings: Settings | Mapping[str, float] | None = None,
    ) -> None:
        # scikit-learn compares these objects by identity when it clones: keep them unchanged until `fit`.
        self.model = model
        self.axis = axis
        self.cutoff = cutoff
        self.decimation = decimation
        self.blocks = blocks
        self.offset = offset
        self.mass = mass
        self.free = free
        self.draws = draws
        self.method = method
        self.settings = settings

    def fit(self, X: Any, y: Any) -> Self:
        """Identify friction and inertia.

        Parameters
        ----------
        X : array_like, shape (sample, 2) or (sample, 3)
            Time [s], position [m or rad] and, optionally, velocity [m/s or rad/s]; or a table with columns of these
            names. Rows are in order of time. Gaps, as between folds, separate the log into segments.
        y : array_like, shape (sample,)
            Effort [N or N*m].

        Returns
        -------
        FrictionRegressor
            Itself.

        Raises
        ------
        InputError
            If `X` and `y` are not a usable log, or an argument of the regressor is invalid.
        """
        columns = _columns_of(X)
        effort = array()(y, "y", None)
        if effort.size != columns["time"].size:
            raise InputError(
                "has a different number of rows than X",
                path="y",
                value=effort.size,
                allowed=str(columns["time"].size),
            )
        options: dict[str, Any] = self.get_params(deep=False) | {"axis": self._axis()}
        self.identified_: Identified = identify(columns | {"effort": effort}, **options)  # type: ignore[arg-type]
        self.n_features_in_ = len(columns)
        if is_table(X):
            self.feature_names_in_ = np.array(list(columns), dtype=object)
        return self

    def predict(self, X: Any) -> np.ndarray:
        """Return the effort of the motion by the best model, with virgin friction at the first row of each segment.

        Parameters
        ----------
        X : array_like, shape (sample, 2) or (sample, 3)
            As in `fit`. The position is low-pass filtered forward and backward with the cut-off frequency.

        Returns
        -------
        ndarray, shape (sample,)
            Effort [N or N*m] of each row.

        Raises
        ------
        InputError
            If a segment of `X` is too short for the filter, or has no motion.
        NotFittedError
            If `fit` was not called; an error of scikit-learn.
        """
        check_is_fitted(self)
        identified = self.identified_
        columns = _columns_of(X)
        axis = self._axis()
        if len(columns) != self.n_features_in_:
            raise InputError(
                "has a different number of columns than the X of fit",
                path="X",
                value=len(columns),
                allowed=str(self.n_features_in_),
            )
        predicted = effort_of_motion(
            identified.plant, identified.model, columns, axis, identified.treatment
        )
        left_out = np.flatnonzero(np.isnan(predicted))
        if left_out.size:
            raise InputError(
                f"{left_out.size} rows are in segments that are too short for the filter, or that have no motion",
                path="X",
                value=f"the first of them at row {left_out[0]}, {columns['time'][left_out[0]]:g} s",
                mend="Remove these rows, or give longer segments",
            )
        return predicted

    def _axis(self) -> Axis | None:
        if self.axis is None:
            return None
        return replace(
            AXIS(self.axis, "axis", None), columns={}, injected=(), table=None, sample_time=None
        )


def _columns_of(X: Any) -> dict[str, np.ndarray]:
    """Return the columns of `X` by name; refuse rows that run backward in time."""
    if is_table(X):
        names = [name for name in COLUMNS if name in list(X)]
        if names[:2] != list(COLUMNS[:2]):
            raise InputError(
                "lacks a column",
                path="X",
                value=list(X),
                allowed=", ".join(COLUMNS),
                mend="Name the columns of X time and position, and give them in SI",
            )
        columns: dict[str, np.ndarray] = {name: np.asarray(X[name], dtype=float) for name in names}
    else:
        values = array(ndim=2, least=1)(X, "X", None)
        if values.shape[1] not in (2, 3):
            raise InputError(
                "must have the columns time, position and, optionally, velocity",
                path="X",
                value=values.shape,
                allowed="shape (sample, 2) or (sample, 3)",
            )
        columns = dict(zip(COLUMNS, np.ascontiguousarray(values.T), strict=False))
    backward = np.flatnonzero(np.diff(columns["time"]) < 0.0)
    if backward.size:
        raise InputError(
            "has rows that run backward in time",
            path="X",
            value=f"row {int(backward[0]) + 1}",
            allowed="rows in order of time",
            mend="Sort X and y by time, and split them for cross-validation with shuffle=False",
        )
    return columns
