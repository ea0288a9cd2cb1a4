"""The order in which models are fitted: by the held-out error of a linear regression of the terms that each model has.

The terms are the level of friction, damping, a fall with the speed, and elements that slip in turn [1]_. Each regression
takes milliseconds, a fit takes seconds: the first fit is then nearly always among the best.

References
----------
.. [1] V. Lampaert, J. Swevers, F. Al-Bender, "Modification of the Leuven integrated friction model structure", IEEE
   Transactions on Automatic Control 47(4), 2002. doi:10.1109/9.995050
"""

from collections.abc import Sequence

import numpy as np

from bristle.core.contracts import FrictionModel
from bristle.core.diagnostic import HeldOut
from bristle.core.least_squares import unbounded
from bristle.identification.estimation import Context, sliding_problem
from bristle.identification.parameters import Role, names_of
from bristle.identification.problem import Fold
from bristle.models.friction import maxwell_slip
from bristle.simulation.statistics import relative_error_percent

FALLS = (0.01, 0.03, 0.1, 0.3)  # of the largest speed, over which friction may fall
ELEMENTS = 6  # deflections at which elements slip
TERMS = {
    "level": Role.LEVEL,
    "damping": Role.VISCOUS,
    "fall": Role.FALL,
    "elements": Role.STIFFNESS,
}
PLANT = "plant"  # terms of every model
Terms = frozenset[str]


def screened(
    context: Context, components: Sequence[FrictionModel], blocks: int
) -> list[FrictionModel]:
    """Return models, those first whose terms explain the rows best; of equally good terms, the fewest lead."""
    if len(components) < 2:
        return list(components)
    terms = {component.name: terms_of(component) for component in components}
    errors = _errors(context, set(terms.values()), blocks)
    least = min(errors.values(), key=lambda error: error.mean_percent)
    margin, alike = context.settings.same_error * least.mean_percent, list[Terms]()
    for chosen, error in errors.items():
        difference, deviation = error.above(least)
        if difference <= max(margin, deviation):
            alike.append(chosen)
    first = min(alike, key=lambda chosen: (len(chosen), errors[chosen].mean_percent))
    return sorted(
        components,
        key=lambda model: (terms[model.name] != first, errors[terms[model.name]].mean_percent),
    )


def terms_of(component: FrictionModel) -> Terms:
    """Return the terms of a model: those whose parameters it has; a state acts like elements."""
    named = {term for term, role in TERMS.items() if names_of(role, component.variables)}
    return frozenset(named | {"elements"} if component.State._fields else named)


def _errors(context: Context, choices: set[Terms], blocks: int) -> dict[Terms, HeldOut]:
    """Return the error of a regression with each choice of terms."""
    problem, dataset, errors = (
        sliding_problem(context.dataset, context.prior),
        context.dataset,
        dict[Terms, HeldOut](),
    )
    variables, target = problem.parameters.variables, dataset.effort - problem.fixed_effort
    falls = np.exp(-np.abs(dataset.velocity)[:, None] / (context.scales.speed * np.array(FALLS)))
    columns = np.column_stack(
        [problem.columns, np.sign(dataset.velocity)[:, None] * falls, _elements(context)]
    )
    columns /= np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    owners = [
        next((term for term, role in TERMS.items() if role.fits(variables[name])), PLANT)
        for name in problem.parameters.free
    ]
    owners += ["fall"] * len(FALLS) + ["elements"] * ELEMENTS
    all_rows = np.ones(dataset.effort.size, dtype=bool)
    folds = (
        problem.folds(blocks, context.settings)[1]
        if blocks
        else [Fold(all_rows, all_rows, all_rows)] * 2
    )
    for chosen in choices:
        used, parts = columns[:, [owner in {PLANT, *chosen} for owner in owners]], list[float]()
        for fold in folds:
            theta = unbounded(used[fold.fitted], target[fold.fitted])
            parts.append(relative_error_percent(target[fold.held_out], used[fold.held_out] @ theta))
        errors[chosen] = HeldOut(tuple(parts), float(np.mean(parts)), float(np.std(parts)))
    return errors


def _elements(context: Context) -> np.ndarray:
    """Return the forces of elements that slip at several deflections, shape (row, element)."""
    dataset, scales, columns = context.dataset, context.scales, list[np.ndarray]()
    for deflection in np.geomspace(scales.shortest, 0.5 * scales.stroke, ELEMENTS).tolist():
        element = maxwell_slip(F_C=1.0, k_i=[1.0 / deflection], nu_i=[1.0], validate=False)
        forces = [segment.friction(element, dataset.sample_time) for segment in dataset.segments]
        columns.append(dataset.rows_of([dataset.filtered(force) for force in forces]))
    return np.column_stack(columns)
