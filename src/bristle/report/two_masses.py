"""Two masses of an axis in reports: a table, lines of the terminal, and files for the simulation."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from bristle.core import Axis, number, scale_of, unit_of, with_unit
from bristle.files import write_model
from bristle.prediction import level_values
from bristle.report.cards import (
    Card,
    Line,
    Step,
    distance_card,
    error_card,
    friction_card,
    labelled,
    quantity_text,
)
from bristle.report.table import Table, capital, percent_text, short_text

if TYPE_CHECKING:
    from bristle.files import Results
    from bristle.identification import Estimate, Identification

ALL_AT_THE_MOTOR = "One encoder does not separate the friction of motor and load: the plant has all friction at the motor"
MOTOR_FILE, TABLE_FILE, EXPERIMENT_FILE = (
    "two_masses_motor.toml",
    "two_masses_table.toml",
    "two_masses.toml",
)
SUM_FILE = "two_masses_sum.toml"
# [rad/s], of the antiresonance, of the velocity loop
FASTEST, OF_ANTIRESONANCE, FOR_POSITION = (2.0 * math.pi * 20.0, 0.2, 0.25)
STROKE = 0.25  # of the recorded range: amplitude of the sine
EXPERIMENT = """\
# The identified motor and table in a velocity and position loop around the motor, with a sine at the top speed of the log.
# Simulate it: bristle run {name}. It compares the errors of the table with a feedforward of one mass and of both masses.
# Add [sensor] side = "load" to close the position loop at the table.
schema = 1
name = "two masses"
kind = "{kind}"
friction = {{ file = "{motor}" }}           # with the plant
{table}controller = {{ model = "cascade", k_p = {k_p:.6g}, k_v = {k_v:.6g}, k_ff = 1.0 }}
reference = {{ model = "sine", amplitude = "{amplitude}", frequency = "{frequency:.6g} Hz" }}
run = {{ duration = "{duration:.6g} s", settle = "{settle:.6g} s", sample_time = "{sample_time:.9g} s" }}

[compare.without]

[compare.one_mass.controller.feedforward]  # sum of the masses, friction of the whole axis from the encoder of the motor
mass = "{inertia}"
friction = {{ file = "{whole}" }}

[compare.two_masses.controller.feedforward]  # both masses, both frictions, and the wind-up of the coupling
plant = "own"
friction = {{ file = "{motor}" }}
{table}"""
TABLE = f'table_friction = {{ file = "{TABLE_FILE}" }}\n'


SIMULATE_BOTH = Step(
    "Compare the feedforward of one mass and of both masses",
    f"bristle run {EXPERIMENT_FILE} --out two_masses",
)


def title_of(identification: Identification) -> str:
    """Return the title of the first screen of an axis with two masses: the errors of both sides, or the frequencies of the coupling."""
    masses, facts = identification.two_masses, identification.treatment
    if masses is None or masses.load is None:
        return f"Antiresonance {with_unit(facts['antiresonance'], 'Hz')}, resonance {with_unit(facts['resonance'], 'Hz')}"
    errors = (
        f"{name} {percent_text(side.best.error_percent)}" for name, side in masses.sides.items()
    )
    return f"Model error: {', '.join(errors)}"


def models_of(identification: Identification) -> str:
    """Return the name of the friction model, or of those of motor and load."""
    masses = identification.two_masses
    if masses is None or masses.load is None:
        return identification.best.name
    names = {side: one.best.name for side, one in masses.sides.items()}
    return (
        ", ".join(f"{name} ({side})" for side, name in names.items())
        if len({*names.values()}) > 1
        else names["motor"]
    )


def elastic_cards(identification: Identification, axis: Axis | None) -> list[Card]:
    """Return masses, stiffness, frequencies and friction of an axis with two masses, each with its interval."""
    masses, facts, fit, cards = (
        identification.two_masses,
        identification.treatment,
        identification.best,
        list[Card](),
    )
    of = {} if masses is None else masses.by_name
    if "motor" in of:
        cards.append(
            _pair(
                "Mass" if fit.plant.kind == "translational" else "Inertia", of["motor"], of["load"]
            )
        )
    elif masses is None:
        cards.append(Card("Motor / load", "–", "not determined", open=True))
    if "stiffness" in of:
        remark = f"play {_value(of['play'])}" if "play" in of else ""
        cards.append(_card("Stiffness", of["stiffness"])._replace(remark=remark))
    hertz = [facts.get(f"antiresonance{part}", 0.0) for part in ("", "_half_width")]
    hertz = (
        [of["antiresonance"].value, of["antiresonance"].half_width]
        if "antiresonance" in of
        else hertz
    )
    if hertz[0]:
        high = (
            facts["resonance"]
            if masses is None or masses.load is None
            else hertz[0] * math.sqrt(1.0 + _inertia_ratio(masses))
        )
        text = " / ".join(number(value, digits=3) for value in (hertz[0], high))
        cards.append(
            Card("Antiresonance / resonance", f"{text}\u00a0Hz", half=100.0 * hertz[1] / hertz[0])
        )
    if masses is None or masses.load is None:
        return [
            *cards,
            friction_card("Lowest sliding friction", fit, axis),
            *filter(None, [distance_card(fit, axis)]),
            error_card(fit),
        ]
    for name, side in masses.sides.items():
        cards.append(
            friction_card(
                f"Friction of the {name}", side.best, axis if name == "motor" else None
            )._replace(sliders=())
        )
    return cards


def _inertia_ratio(masses: Any) -> float:
    of = masses.by_name
    return float(
        of["load"].value / (of["motor"].value + (of["screw"].value if "screw" in of else 0.0))
    )


def _card(label: str, item: Any) -> Card:
    half = 100.0 * item.half_width / item.value
    return Card(label, quantity_text(item.value, half, item.unit), half=half)


def _pair(label: str, motor: Any, load: Any) -> Card:
    """Return the card of motor and load in a common unit, with the wider interval."""
    scale = scale_of(motor.unit, max(motor.value, load.value))
    text = " / ".join(number(item.value * scale.factor, digits=3) for item in (motor, load))
    halves = [100.0 * item.half_width / item.value for item in (motor, load)]
    half = max(halves) if math.isfinite(max(halves)) else None
    return Card(f"{label}, motor / load", f"{text}\u00a0{scale.unit}", half=half, open=half is None)


def two_masses_table(identification: Identification) -> Table | None:
    """Return masses, coupling and friction of either side with their 95 % intervals; None if the log does not show both masses."""
    masses = identification.two_masses
    if masses is None:
        return None
    rows = [
        ("", capital(item.meaning), _value(item), _share(item) or "–") for item in masses.quantities
    ]
    for name, side in _sides(masses).items():
        fit = side.best
        for estimate in fit.estimates:
            if estimate.name not in fit.friction.values or estimate.status == "held":
                continue
            half = (
                math.inf if estimate.ends is None else 0.5 * (estimate.ends[1] - estimate.ends[0])
            )
            rows.append(
                (
                    capital(f"friction of the {name}: {fit.name}"),
                    estimate.name,
                    with_unit(estimate.value, estimate.unit),
                    _width(half, estimate.value),
                )
            )
    source = (
        "the sensor in the coupling"
        if masses.measured
        else "the encoder of the motor"
        if masses.load is None
        else "both encoders"
    )
    caption = (
        f"Motor and load as two masses, from {source}. ± is the half-width of the 95 % interval"
    )
    caption = f"{caption}. {remark}" if (remark := _remark(masses)) else caption
    return Table(caption, ("Friction", "Quantity", "Value", "95 % interval [%]"), rows)


def two_masses_lines(identification: Identification) -> list[Line]:
    """Return masses, coupling and friction levels for the terminal, or why the log does not show them; empty for a rigid axis."""
    masses = identification.two_masses
    if masses is None:
        return _without(identification.reason_for_one_mass, identification.treatment)
    shares = map(_share, masses.quantities)
    texts = [
        f"{item.meaning} {_value(item)}" + f" {share} %" * bool(share)
        for item, share in zip(masses.quantities, shares, strict=True)
    ]
    for name, side in _sides(masses).items():
        fit, sides = side.best, level_values(side.best)
        parts = [fit.name, *(_level(fit.parameters[level]) for level in fit.levels)]
        constant = 0.0 if sides is None else sides.constant
        parts += (
            [f"constant force {with_unit(constant, unit_of('force', fit.friction.kind))}"]
            if constant
            else []
        )
        texts.append(
            f"friction of the {name}: {', '.join(parts)}, model error {percent_text(fit.error_percent)}"
        )
    texts += filter(None, [_remark(masses)])
    return labelled("Two masses", texts)


def _level(estimate: Estimate) -> str:
    unsure = "" if estimate.status in ("identified", "held") else " (not identified)"
    return f"{estimate.name} {with_unit(estimate.value, estimate.unit)}{unsure}"


def _without(reason: str, facts: Mapping[str, Any]) -> list[Line]:
    """Return why a log does not show both masses, and the frequencies that it shows."""
    texts = [f"not determined: {reason}"] if reason else []
    for name in ("antiresonance", "resonance"):
        if reason and name in facts:
            texts.append(
                f"{name} {with_unit(facts[name], 'Hz')} {_width(facts[f'{name}_half_width'], facts[name])} %"
            )
    return labelled("Two masses", texts)


def write_two_masses(
    folder: Results, identification: Identification, provenance: Mapping[str, str]
) -> None:
    """Write plant and friction as model files, and an experiment file that simulates them."""
    masses, log = identification.two_masses, identification.log
    if masses is None or not masses.is_elastic:
        return
    plant = masses.plant
    write_model(folder / MOTOR_FILE, plant, masses.motor_friction, provenance=provenance)
    if masses.table_friction is not None:
        write_model(folder / TABLE_FILE, None, masses.table_friction, provenance=provenance)
    write_model(
        folder / SUM_FILE,
        None,
        masses.at_the_motor(identification.best.friction),
        provenance=provenance,
    )
    position = log.position.values
    amplitude = STROKE * float(position.max() - position.min()) / masses.arm
    speed = float(identification.treatment["velocity_max"]) / masses.arm
    frequency = speed / (2.0 * math.pi * amplitude)
    inertia = plant.values["J"] + plant.values["M"] * masses.arm**2
    pace = min(
        FASTEST,
        OF_ANTIRESONANCE * 2.0 * math.pi * masses.by_name["antiresonance"].value,
        0.1 / log.sample_time,
    )
    gains = {"k_p": FOR_POSITION * pace, "k_v": pace * inertia}
    text = EXPERIMENT.format(
        name=EXPERIMENT_FILE,
        motor=MOTOR_FILE,
        table="" if masses.table_friction is None else TABLE,
        whole=SUM_FILE,
        kind=masses.kind,
        inertia=f"{inertia:.9g} {unit_of('mass', masses.kind)}",
        amplitude=f"{amplitude:.6g} {unit_of('length', masses.kind)}",
        frequency=frequency,
        duration=3.0 / frequency,
        settle=1.0 / frequency,
        sample_time=log.sample_time,
        **gains,
    )
    folder.write(EXPERIMENT_FILE, text)


def _sides(masses: Any) -> dict[str, Identification]:
    """Return the sides with a friction of their own; that of one encoder is the friction of the axis, that of the nut a quantity."""
    motor = "bearings and of the unloaded nut" if masses.nut and not masses.measured else "motor"
    return {} if masses.load is None else {motor: masses.motor, "load": masses.load}


def _remark(masses: Any) -> str:
    """Return which frictions the log does not separate, and why; empty if it separates all."""
    if masses.load is None:
        return ALL_AT_THE_MOTOR
    if masses.rigid:
        return str(masses.rigid)
    if masses.nut_is_separable:
        return ""
    cause = "rarely acts against the motion" if masses.nut_is_masked else "is too small"
    share = short_text(100.0 * masses.by_name["nut"].half_width)
    other = "load" if masses.measured else "bearings"
    return (
        f"The log does not separate friction of the nut from that of the {other}, because the force of the coupling {cause}. "
        f"Load and stiffness assume a nut without friction. Otherwise they are smaller by up to {share} %"
    )


def _value(item: Any) -> str:
    bounded = item.value <= item.half_width < math.inf
    return (
        with_unit(item.value, item.unit)
        if not bounded
        else f"below {with_unit(item.value + item.half_width, item.unit)}"
    )


def _width(half: float, value: float) -> str:
    return (
        f"± {number(100.0 * half / abs(value), digits=2)}" if value and math.isfinite(half) else "–"
    )


def _share(item: Any) -> str:
    """Return the half-width of the interval in percent of the value; empty for a bound."""
    return _width(item.half_width, item.value) if item.half_width < item.value else ""
