"""All certificates of a model."""

from typing import Any

from bristle.certificates.certificate import Certificate, as_friction
from bristle.certificates.dissipation import dissipation, fattest_loop
from bristle.certificates.passive import passive
from bristle.certificates.quasi_static import holding_of
from bristle.certificates.slow_motion import closure, drift, well_posed
from bristle.core.contracts import HysteresisOperator, Model
from bristle.core.edge import guarded, many, optional
from bristle.core.edge import model as of_family
from bristle.core.units import quantity
from bristle.core.variable import Variable
from bristle.friction import unvaried

PAIR = optional(many(lambda raw, path, kind: raw, least=2, most=2))  # in units that the model tells


@guarded(model=of_family("friction", "hysteresis"), force_ripple=PAIR, loop=PAIR)
def check(model: Model, *, force_ripple: Any = None, loop: Any = None) -> dict[str, Certificate]:
    """Return whether a friction model is fit to be used: one certificate for each question.

    Parameters
    ----------
    model : Model
        A friction model, or a hysteresis operator, with parameters. An operator is taken as friction whose position is
        the input; where its loops run the other way around (a magnet), energy is counted as it is in magnets. Friction
        that varies along the axis is taken as it is in the middle.
    force_ripple : (low, high), optional
        Forces between which the contact is loaded up and down, for `drift`: numbers [N or N*m], or text with a unit.
        Between 0.3 and 0.6 of the break-away force where not given.
    loop : (x1, x2), optional
        Positions where the loop ``0 -> x1 -> x2 -> x1`` of `closure` turns: numbers [m or rad], or text with a unit. At
        0.85 of the break-away force, and halfway back, where not given.

    Returns
    -------
    dict of str to Certificate
        ``well_posed``, ``passive``, ``drift``, ``closure`` and ``dissipation``.

    Raises
    ------
    InputError
        If `model` is neither, or the contact does not rest under the ripple.

    Examples
    --------
    >>> from bristle import friction
    >>> found = check(friction.coulomb(F_C=2.0))
    >>> found["drift"].value, found["closure"].applies
    (0.0, False)
    """
    force, length = Variable("force", "force of the ripple"), Variable("length", "where the loop turns")
    if isinstance(model.component, HysteresisOperator):
        force, length = (Variable(name, name) for name in (model.component.output, model.component.input))
        model = as_friction(model)
    else:
        model = unvaried(model)
    pairs: dict[str, Any] = {}
    for path, raw, variable in (("force_ripple", force_ripple, force), ("loop", loop, length)):
        ends = (quantity(value, variable, model.kind, path=f"{path}[{i}]") for i, value in enumerate(raw or ()))
        pairs[path] = tuple(ends) or None
    holding = holding_of(model)
    fattest = fattest_loop(model)
    return {
        "well_posed": well_posed(model, holding),
        "passive": passive(model, fattest.is_magnetic),
        "drift": drift(model, holding, pairs["force_ripple"], fattest.is_magnetic),
        "closure": closure(model, holding, pairs["loop"]),
        "dissipation": dissipation(model, holding, fattest),
    }
