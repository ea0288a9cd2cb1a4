"""The limit of a drive, as its controller knows it."""

import numpy as np

from bristle.core.contracts import Model


def within_drive(controller: Model, limit: float, injected: np.ndarray | None = None) -> Model:
    """Return a controller that does not ask a drive for more than it gives, so that its integral does not wind up.

    Parameters
    ----------
    controller : Model
        The control law; one without a parameter ``limit`` is returned as it is.
    limit : float
        Largest effort of the drive [N or N*m].
    injected : ndarray, optional
        Known inputs that join the output of the law before that limit [N or N*m]: they may take off again what the law
        asks for beyond it.

    Returns
    -------
    Model
        The same law, its ``limit`` lowered to that of the drive.
    """
    limit += 0.0 if injected is None else float(np.max(np.abs(injected), initial=0.0))
    if "limit" not in controller.component.variables or controller.values["limit"] <= limit:
        return controller
    return controller.with_values(limit=limit)
