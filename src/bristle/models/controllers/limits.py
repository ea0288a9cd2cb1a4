"""The limit of a drive in its controller."""

import numpy as np

from bristle.core.contracts import Model


def within_drive(controller: Model, limit: float, injected: np.ndarray | None = None) -> Model:
    """Return a controller that respects the limit of a drive, so that its integral does not wind up.

    Parameters
    ----------
    controller : Model
        The control law; a law without a parameter ``limit`` is returned unchanged.
    limit : float
        Largest effort of the drive [N or N*m].
    injected : ndarray, optional
        Known inputs, added to the output of the law before that limit [N or N*m]; they may reduce an output beyond the
        limit again.

    Returns
    -------
    Model
        The same law, its ``limit`` lowered to that of the drive.
    """
    limit += 0.0 if injected is None else float(np.max(np.abs(injected), initial=0.0))
    if "limit" not in controller.component.variables or controller.values["limit"] <= limit:
        return controller
    return controller.with_values(limit=limit)
