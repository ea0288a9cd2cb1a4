"""Tables of an identified model: its parameters, the compared models, the friction for the drive."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from bristle.core import Axis, Kind, number, printable, scale_of, typeset, unit_of, with_unit
from bristle.identification import OPEN
from bristle.prediction import drive_units, level_values
from bristle.report.table import Quantity, Table, interval_text, short_text

if TYPE_CHECKING:
    from bristle.identification import Estimate, Fit, Identification, Settings
    from bristle.simulation.certificates import Certificate

STATUS_WORDS = {
    "identified": "",
    "held": "held constant",
    "at_edge": "at the edge of its range",
    "unidentifiable": "not identified",
}
MOST_PERCENT, LEAST_PERCENT = 1000.0, 1e-3  # of a value, the limits for a half-width in percent
RANKED = (
    "Models, smallest held-out error first. bristle chose the fewest parameters within one standard error of the smallest error. "
    "A model with half or more of its parameters not identified gives way to a simpler model"
)
RANKED_BY_FIT = (
    "Models compared: the error of the fit decides, because the log has no held-out stretches"
)
DOUBTED, WITH_CONSTANT = "doubtful: see the warnings", "valid only with the given offset"


# The uses that need a certificate; a feedforward along the desired motion only needs a well-posed model.
USES = {
    "well_posed": "every use",
    "passive": "a simulation that must not gain energy, friction feedforward along the measured motion",
    "drift": "a simulation of an axis that holds a load",
    "closure": "a simulation of small motions inside large ones",
    "dissipation": "a simulation that must not gain energy, friction feedforward along the measured motion",
}


# Quantity -> names in `LevelValues` with their labels.
LEVELS = {
    "force": {
        "forward": "Friction forward, F+",
        "backward": "Friction backward, F\u2212",
        "constant": "Constant force",
    },
    "force*time/length": {
        "viscous_forward": "Viscous friction forward",
        "viscous_backward": "Viscous friction backward",
    },
    "mass": {"inertia": "Mass or inertia"},
}


def values_to_enter(fit: Fit, axis: Axis | None) -> Table:
    """Return friction, constant force and inertia for a drive without a table, in the units of the drive first."""
    kind, levels, units, rows = (
        fit.plant.kind,
        level_values(fit),
        drive_units(axis, fit.plant.kind),
        [],
    )
    unknown = [estimate.name for estimate in fit.estimates if estimate.status == "unidentifiable"]
    unknown = ["constant"] * ("offset" in unknown) + ["inertia"] * (
        fit.inertia is not None and fit.inertia.name in unknown
    )
    for quantity, name, label in (
        (quantity, *named) for quantity, names in LEVELS.items() for named in names.items()
    ):
        if name not in unknown and (value := getattr(levels, name, None)):
            words = [
                f"{number(unit.of(value), digits=3)} {typeset(printable(unit.name))}"
                for unit in units.of(quantity)
            ]
            rows.append((label, "; ".join(words), with_unit(value, unit_of(quantity, kind))))
    below = (
        ""
        if levels is None
        else f": at most {with_unit(levels.deviation, unit_of('force', kind))} below the steady friction, never above it"
    )
    return Table(
        f"Values to enter into the drive{below}", ("Value", "In the drive's units", "SI"), rows
    ).without_empty_columns()


def parameter_table(fit: Fit, axis: Axis | None = None) -> Table:
    """Return the parameters of a fit with their uncertainty, in SI and in the units of the drive.

    Standard errors of least squares appear only if the fit has no intervals.
    """
    plain = fit.resampling is None
    values = drive_values(fit, axis)
    rows = [
        _parameter_row(
            estimate, values.get(estimate.name, {}), plain=plain, remark=_remark(fit, estimate)
        )
        for estimate in (*fit.estimates, *fit.combinations)
        # An infinite value switches a term of the model off.
        if estimate.status != "held" or not math.isinf(estimate.value)
    ]
    return Table.of(f"Parameters of {fit.name}", rows).without_empty_columns()


def _parameter_row(
    estimate: Estimate, in_units: Mapping[str, float], *, plain: bool, remark: str
) -> dict[str, str]:
    std, size, ends = estimate.std, abs(estimate.value), estimate.interval
    std = std if plain and std is not None and math.isfinite(std) else None
    if ends is not None and ends[0] < 0.0 < ends[1] and size < 0.1 * max(-ends[0], ends[1]):
        size = max(-ends[0], ends[1])  # for an interval with zero well inside
    scale = scale_of(estimate.unit, size or std or 0.0)
    scaled, half = None if std is None else std * scale.factor, _half(estimate.interval_percent)
    # The digits follow the standard error, or else the interval.
    precision, interval = scaled, "–"
    if ends is not None:
        low, high = (scale.factor * end for end in ends)
        width = max(0.5 * (high - low), LEAST_PERCENT / 100.0 * max(abs(low), abs(high)))
        interval = interval_text(number(low, width), number(high, width))
        if precision is None and high != low:
            precision = max(
                0.5 * (high - low), LEAST_PERCENT / 100.0 * abs(scale.factor * estimate.value)
            )
    return {
        "Parameter": estimate.name,
        "Meaning": estimate.description,
        "Value": number(estimate.value * scale.factor, precision),
        "Standard error": "–" if scaled is None else f"± {number(scaled, scaled)}",
        "95 % interval": interval,
        "Unit": scale.unit or "–",
        "Standard error [%]": _percent(estimate.relative_std_percent) if plain else "–",
        "95 % interval [%]": half if half == "–" or half.startswith((">", "<")) else f"± {half}",
        "In the drive's units": "; ".join(
            _in_unit(value, name) for name, value in in_units.items()
        ),
        "Remark": remark,
    }


def _remark(fit: Fit, estimate: Estimate) -> str:
    """Return the remark on a parameter."""
    if estimate.status != "identified":
        return STATUS_WORDS.get(estimate.status, estimate.status)
    rough = (estimate.name,) if estimate.is_rough else ()
    remarks = {
        "roughly identified": rough,
        "effective": fit.effective,
        DOUBTED: fit.doubted,
        WITH_CONSTANT: fit.with_constant,
    }
    return "; ".join(text for text, names in remarks.items() if estimate.name in names)


def _in_unit(value: float, name: str) -> str:
    """Return a value in a unit of the drive, in short: percent of rated, turns of the motor."""
    unit, at, _ = name.partition(" at the motor")
    if at:
        return f"{with_unit(value, unit, digits=4)} (motor)"
    short = (
        name.removesuffix(" of rated")
        .replace("rpm of the motor", "rpm")
        .replace("deg of the motor", "deg (motor)")
    )
    return f"{number(value)} {typeset(printable(short))}"


def _half(percent: float | None) -> str:
    """Return the half-width of an interval in percent; very large and very small half-widths have no digits."""
    if percent is not None and math.isfinite(percent):
        if percent > MOST_PERCENT:
            return f"> {MOST_PERCENT:.0f}"
        if percent < LEAST_PERCENT:
            return f"< {LEAST_PERCENT:g}"
    return _percent(percent)


def half_text(percent: float | None) -> str:
    """Return the half-width of an interval in words; "open" if it does not identify the parameter."""
    return "open" if percent is None or percent >= OPEN else f"± {number(percent, digits=2)} %"


def _percent(value: float | None) -> str:
    return "–" if value is None or not math.isfinite(value) else number(value, digits=2)


def comparison_table(identification: Identification, *, details: bool = True) -> Table:
    """Return the models by their held-out error, with the rule of the choice; `details` adds criteria and condition numbers."""
    in_order = sorted(
        identification.fits, key=lambda fit: fit.held_out.mean_percent if fit.held_out else math.inf
    )
    smallest, rows = in_order[0].held_out, []
    for fit in in_order:
        information, difference = fit.information, "–"
        if smallest is not None and fit.held_out is not None:
            mean, error = fit.held_out.above(smallest)
            difference = (
                "0" if fit is in_order[0] else f"+{short_text(mean)} ± {number(error, digits=2)}"
            )
        unknown = [
            estimate.name
            for estimate in fit.estimates
            if estimate.status in ("unidentifiable", "at_edge")
        ]
        row = {
            "Model": fit.name,
            "Chosen": "yes" if fit is identification.fits[0] else "",
            "Parameters": str(
                sum(estimate.status != "held" for estimate in fit.estimates) + fit.further
            ),
            "Held-out error [%]": "–"
            if fit.held_out is None
            else short_text(fit.held_out.mean_percent),
            "Above the smallest [%]": difference,
            "Error of the fit [%]": short_text(fit.error_percent),
        }
        if details:
            row |= {
                "AIC, above the best": "–" if information is None else short_text(information.aic),
                "BIC, above the best": "–" if information is None else short_text(information.bic),
                "Condition number": short_text(fit.condition_number),
            }
        rows.append(row | {"Not identified": ", ".join(unknown) or "–"})
    return Table.of(RANKED_BY_FIT if smallest is None else RANKED, rows)


def drive_rows(table: Sequence[tuple[float, float]], kind: Kind, axis: Axis | None = None) -> Table:
    """Return the drive table in readable units, and in the units of the drive and of its log."""
    speed = Quantity.of(unit_of("length/time", kind), (v for v, _ in table), digits=5)
    effort = Quantity.of(unit_of("force", kind), (force for _, force in table), digits=4)
    further, word = (
        drive_units(axis, kind),
        "Friction torque" if kind == "rotational" else "Friction force",
    )
    velocities, efforts = (
        {
            f"[{typeset(printable(unit.name))}]": unit
            for unit in units
            if typeset(printable(unit.name)) != column.scale.unit
        }
        for units, column in ((further.velocities, speed), (further.efforts, effort))
    )
    rows = [
        {
            "Entry": str(index),
            speed.head("Velocity"): _side(v) or speed.cell(v),
            effort.head(word): effort.cell(force),
        }
        | {head: _side(v) or number(unit.of(v)) for head, unit in velocities.items()}
        | {head: number(unit.of(force)) for head, unit in efforts.items()}
        for index, (v, force) in enumerate(table, 1)
    ]
    return Table.of("Friction over velocity, for the drive", rows)


def _side(v: float) -> str:
    """Return the side of a zero velocity; empty for other velocities."""
    if v == 0.0:
        return "−0" if math.copysign(1.0, v) < 0.0 else "+0"
    return ""


def as_csv(table: Sequence[tuple[float, float]], kind: Kind) -> str:
    """Return the drive table as comma-separated values in SI."""
    lines = [f"velocity [{unit_of('length/time', kind)}],effort [{unit_of('force', kind)}]"]
    return "\n".join(lines + [f"{v:.6g},{force:.6g}" for v, force in table])


def drive_values(fit: Fit, axis: Axis | None) -> dict[str, dict[str, float]]:
    """Return the value of each parameter in its units other than SI, by name."""
    variables, values = fit.plant.component.variables | fit.friction.component.variables, {}
    of_drive = drive_units(axis, fit.plant.kind)
    for estimate in fit.estimates:
        if estimate.name in variables and math.isfinite(estimate.value):
            units = of_drive.of(variables[estimate.name].quantity)
            values |= (
                {estimate.name: {unit.name: unit.of(estimate.value) for unit in units}}
                if units
                else {}
            )
    return values


def changed_settings(settings: Settings) -> Table | None:
    """Return the thresholds that differ from the default; None if all are defaults."""
    rows = [
        {
            "Name": threshold.name,
            "Value": f"{getattr(settings, threshold.name):g}",
            "Default": f"{threshold.default:g}",
            "Unit": threshold.unit if threshold.unit != "1" else "–",
            "Meaning": f"{threshold.meaning} ({threshold.source})"
            if threshold.source
            else threshold.meaning,
        }
        for threshold in settings.described()
        if threshold.name in settings.changed
    ]
    return Table.of("Changed thresholds", rows) if rows else None


def certificate_table(name: str, certificates: Mapping[str, Certificate]) -> Table:
    """Return the certificates of a model, with verdict and advice."""
    rows = [
        {
            "Certificate": key,
            "Verdict": {True: "passed", False: "FAILED", None: "does not apply"}[
                certificate.passed
            ],
            "Found": ""
            if certificate.value is None
            else with_unit(certificate.value, certificate.unit),
            "Limit": ""
            if certificate.threshold is None
            else with_unit(certificate.threshold, certificate.unit),
            "Meaning and advice": certificate.advice,
            "Matters for": USES[key],
        }
        for key, certificate in certificates.items()
    ]
    return Table.of(f"Certificates of {name}", rows)
