"""LinuxCNC: a HAL component with the C of a friction model, the HAL file that links it, a table, and a self-test.

The component extrapolates the commanded position by the lead of the effort from the last three commands:

    x + v lead + a lead^2 / 2.

It feeds the friction there, with the constant force of the model, and gravity and cogging of the plant. In a component,
each pin is a macro. Therefore the C, in the same file, stands between directives that save and restore these names.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core import InputError, unit_of, with_unit
from bristle.engine.translation.build import Builder
from bristle.engine.translation.tree import REAL, Unit, struct_type
from bristle.exports import NAME, Product, subject as subjects
from bristle.exports.c import CFiles, law_code_facts
from bristle.exports.c_parts import constant_text
from bristle.exports.described import Request, Source, plain, rendered, with_rights
from bristle.exports.drive import error_on_log, losses, side_of
from bristle.exports.feed import fed
from bristle.exports.law import Law, law_walk, samples_along, settled_law
from bristle.exports.loops import cycle_of, late_of
from bristle.exports.subject import Subject
from bristle.models.controllers.feedforward import Rule
from bristle.models.plants.terms import Place, effort_at, place_of
from bristle.prediction.drive_units import DriveUnit, signed_units

PINS = (
    "reference",
    "feed",
    "gain",
    "gain_now",
    "fault",
    "reset",
    "scale",
    "effort_scale",
    "lead",
    "lead_max",
    "limit",
    "slew",
    "clock",
)
MACROS = (*PINS, "fperiod", "data")  # Names in a component that the preprocessor replaces
MOST_PINS = 20  # a stream of the self-test has 21 pins: these inputs and the expected effort
LONGEST_NAME = 47 - len(".effort-scale")  # HAL names have at most 47 characters
USUAL = {"translational": DriveUnit("mm", 1e-3), "rotational": DriveUnit("deg", math.radians(1.0))}
PERIOD_NS = 1_000_000  # [ns] of the thread of the self-test
STEPS = 400  # references of the self-test
PER_DIRECTION = 8  # entries of a table with 16 points
NEAR_REST = 1e-3  # of the largest speed: the table is a straight line through rest below it
PER = {"velocity": " a second"} | dict.fromkeys(
    ("acceleration", "acceleration_ahead"), " a second squared"
)
LEAD_MAX = 0.02  # [s]: beyond it, three commands do not predict the motion
FILES = {
    "{}.comp": "hal/component.comp",
    "{}.hal": "hal/machine.hal",
    "{}_selftest.hal": "hal/selftest.hal",
    "README.md": "hal/README.md",
}


class Settings(NamedTuple):
    """Parameters of the component: units of the machine, and lead [s] and limit [unit of effort, 0 for no limit] of the feed."""

    position: DriveUnit
    effort: DriveUnit
    lead: float
    limit: float


def write(request: Request) -> Product:
    """Return the component, the HAL files with their units and lead, and the self-test."""
    refuse_velocity_mode(request, "hal")
    checksum = request.source.provenance.get("model_sha256", "") or request.source.model_hash
    request = replace(request, name=_name_of(request.name, checksum), single=False)
    settings = settings_of(request)
    place = place_of(request.plant)
    friction = subjects.settled_subject(subjects.subject_of(request.sampled))
    references = (
        subjects.walk_of(friction, 1e-9 * PERIOD_NS).positions(STEPS) / settings.position.si
    )
    feeds = feeds_of(friction, place, references, settings, request.share)
    table = ""
    losses_of_table = ("the largest speed is unknown: no table",)
    if request.speed > 0.0:
        table, losses_of_table = _table(request, settings)
    notes = [
        "link the component only to an amplifier in torque mode: the output of the controller must be its torque command",
        f"parameters of the component: scale {settings.position.si:.9g} {unit_of('length', request.model.kind)} for 1 "
        f"{settings.position.name}, effort-scale {settings.effort.si:.9g} {unit_of('force', request.model.kind)} for 1 "
        f"{settings.effort.name}, lead {with_unit(settings.lead, 's')}. Compare the units with those of the machine",
    ]
    place_fed = None
    if place.g_sin or place.g_cos or not place.is_link:
        place_fed = place
        notes.append(
            "the feed contains gravity, cogging and springs of the position: the reference must have the zero of the log"
        )
    notes += [f"{request.name}_table.hal: {loss}" for loss in losses_of_table]
    facts = _facts(request, friction, place_fed, settings)
    facts |= {"notes": [plain(note) for note in notes], "lincurve": table}
    texts = {
        file.format(request.name): rendered(template, facts) for file, template in FILES.items()
    }
    if table:
        texts[f"{request.name}_table.hal"] = table
    files: dict[str, str | bytes] = {**with_rights(texts, request.source)}
    return Product(files | _played(request.name, references[:, None], feeds), tuple(notes))


def refuse_velocity_mode(request: Request, target: str) -> None:
    """Refuse an axis whose amplifier does not follow an effort."""
    if request.mode != "torque":
        raise InputError(
            "feeds an effort forward, but the output of this axis is the velocity command of its amplifier",
            path=target,
            value=request.mode,
            allowed="an amplifier in torque mode",
            mend="Set the amplifier to torque mode, or use the friction compensation of the amplifier (--to table)",
        )


def _played(name: str, inputs: np.ndarray, outputs: np.ndarray) -> dict[str, str]:
    """Return the inputs of a self-test with the expected output, and the lines of halsampler, for rows of inputs."""
    rows = list(zip(inputs.tolist(), outputs.tolist(), strict=True))
    played = "".join(f"{' '.join(map(repr, row))} {output!r}\n" for row, output in rows)
    return {
        f"{name}_selftest.txt": played,
        f"{name}_selftest_expected.txt": "".join(
            f"{row[0]:f} {output:f} {0.0:f} \n" for row, output in rows
        ),
    }


def hal_law_files(law: Law, name: str, source: Source) -> Product:
    """Return the component of a control law, and its self-test."""
    name = _name_of(name, source.model_hash)
    law = settled_law(law)
    facts = law_code_facts(law, name, source) | {"drive": None}
    walk, _, efforts = law_walk(law, STEPS)
    samples = samples_along(walk, law, STEPS)
    pins = {}
    values = []
    for key in law.inputs:
        if key.endswith("_ahead"):
            pins[key] = [f"{key}_{k}" for k in range(law.samples_ahead)]
            values.append(f"{{{', '.join(f'{pin} * scale' for pin in pins[key])}}}")
        else:
            pins[key] = [key]
            values.append(f"{key} * scale")
    listed = [pin for names in pins.values() for pin in names]
    if len(listed) > MOST_PINS:
        raise InputError(
            "has too many inputs for halstreamer",
            path="hal",
            value=len(listed),
            allowed=f"{MOST_PINS} pins or fewer",
            mend="Reduce the delay of the experiment, omit the plant with a screw, or export the law in C",
        )
    code = rendered("c/law.h", facts) + rendered("c/law.c", facts).replace(
        f'#include "{name}.h"\n', ""
    )
    position, effort = signed_units(law.variant.axis, law.controller.kind)
    if law.variant.axis is None:
        position = USUAL[law.controller.kind]
    facts |= {
        "code": code,
        "macros": [
            *listed,
            "effort",
            "enable",
            "fault",
            "scale",
            "effort_scale",
            "fperiod",
            "data",
        ],
        "pins_of": pins,
        "scale": repr(position.si),
        "effort_scale": repr(effort.si),
        "values": ", ".join(values),
        "per": PER,
    }
    facts |= _test_facts(
        name, listed, "effort", {"scale": 1, "effort-scale": 1, "enable": 1}, round(1e9 * law.dt)
    )
    files = {
        f"{name}.comp": rendered("hal/law.comp", facts),
        f"{name}_selftest.hal": rendered("hal/selftest.hal", facts),
    }
    rows = np.array(
        [
            [x for key in law.inputs for x in np.atleast_1d(getattr(sample, key))]
            for sample in samples
        ]
    )
    note = (
        f"run the component in a thread of {1e3 * law.dt:g} ms, the sample time of the experiment"
    )
    return Product({**with_rights(files, source), **_played(name, rows, efforts)}, (note,))


def _test_facts(
    name: str, inputs: Sequence[str], output: str, presets: Mapping[str, Any], period_ns: int
) -> dict[str, Any]:
    """Return the facts of the self-test: pins of the component, its parameters in the test, and the period of the thread [ns]."""
    pins = {
        "pin": name.replace("_", "-"),
        "played": [pin.replace("_", "-") for pin in inputs],
        "output": output,
    }
    return pins | {"presets": presets, "steps": STEPS, "depth": STEPS + 100, "period_ns": period_ns}


def _name_of(name: str, checksum: str) -> str:
    """Return the name of the component; without a name of the user, the hash of the model file, the model or the law."""
    if name == NAME:
        if checksum:
            return f"bristle_{checksum[:8]}"
        return "bristle_axis"
    if len(name) > LONGEST_NAME:
        raise InputError(
            "is too long for a HAL component",
            path="name",
            value=name,
            allowed=f"{LONGEST_NAME} characters or fewer",
        )
    return name


def settings_of(request: Request) -> Settings:
    """Return units and signs of the log, or mm or degrees; the identified lead, or that of the loop; the limit of the drive."""
    axis = request.axis
    kind = request.model.kind
    position, effort = signed_units(axis, kind)
    limit = 0.0
    if axis is not None and axis.effort_limit:
        limit = axis.effort_limit / abs(effort.si)
    rounded = (float(f"{value:.6g}") for value in (min(_lead_of(request), LEAD_MAX), limit))
    if axis is None:
        position = USUAL[kind]
    return Settings(position, effort, *rounded)


def _lead_of(request: Request) -> float:
    """Return the lead [s]: the lateness; without an identified one, a cycle more, for the next step."""
    late = late_of(request)
    if "delay" in request.treatment:
        return late
    return late + cycle_of(request)


def feeds_of(
    friction: Subject, place: Place, references: np.ndarray, settings: Settings, rule: Rule
) -> np.ndarray:
    """Return the feed at each reference at gain 1, as the component computes it: same operations, same order."""
    dt = PERIOD_NS * 1e-9
    lead = settings.lead
    before = None
    v_before = 0.0
    ahead = []
    rate = 1.0 / dt
    for reference in references.tolist():
        x = reference * settings.position.si
        v = 0.0
        if before is not None:
            v = (x - before) * rate
        a = (v - v_before) * rate
        ahead.append(x + v * lead + 0.5 * a * lead * lead)
        before = x
        v_before = v
    places = np.array(ahead)
    friction_fed = fed(places, friction.forces(places, dt).tolist(), dt, rule)
    return np.array(
        [
            (force + effort_at(x, place)) / settings.effort.si
            for x, force in zip(ahead, friction_fed.tolist(), strict=True)
        ]
    )


def _facts(
    request: Request, friction: Subject, place: Place | None, settings: Settings
) -> dict[str, Any]:
    """Return the facts of the templates: the C, pins and parameters, and the self-test."""
    name = request.name
    constants = ""
    of_place = ""
    if place is not None:
        builder = Builder()
        of_place = (
            f" + place_{builder.function(effort_at, [REAL, struct_type(place)]).name}(ahead, place)"
        )
        for function in builder.unit.functions:
            function.name = f"place_{function.name}"
        friction = replace(friction, unit=Unit([*friction.unit.functions, *builder.unit.functions]))
    c = CFiles(friction, replace(request, axis=None), STEPS, feeds=True)
    if place is not None:
        constants = "\n" + constant_text(
            "place", place, struct_type(place), c.new_printer(), "place"
        )
    # Inlined into the function of the component, the step lacks registers: lugre needs 13 ns more.
    facts = c.facts() | {"device": "static __attribute__((noinline)) "}
    facts |= {"data": facts["data"] + constants}
    code = "".join(rendered(part, facts) for part in ("c/structure.h", "c/head.c", "c/steps.c"))
    presets = {
        "scale": settings.position.si,
        "effort-scale": settings.effort.si,
        "lead": settings.lead,
        "limit": 0,
        "slew": "1e9",
        "gain": 1,
    }
    values = {
        "scale": settings.position.si,
        "effort_scale": settings.effort.si,
        "lead": settings.lead,
        "limit": settings.limit,
    }
    return (
        facts
        | {name: repr(value) for name, value in values.items()}
        | {
            "code": code.replace(f'#include "{name}.h"\n', ""),
            "macros": MACROS,
            "lead_max": LEAD_MAX,
        }
        | {"units": settings, "effort_of_place": of_place}
        | _test_facts(name, ["reference"], "feed", presets, PERIOD_NS)
    )


def _table(request: Request, settings: Settings) -> tuple[str, Sequence[str]]:
    """Return the HAL file of a table of velocity and effort in units of the machine, and the losses of the table."""
    sides = {way: side_of(request.model, way, request.speed, PER_DIRECTION) for way in (1.0, -1.0)}
    points = points_of(
        {way: side.entries for way, side in sides.items()}, NEAR_REST * request.speed, settings
    )
    entries: Mapping[float, np.ndarray] = {way: side.entries for way, side in sides.items()}
    lost = (
        *losses(
            request.model,
            sides[1.0],
            sides[-1.0],
            settings.effort._replace(si=abs(settings.effort.si)),
            symmetric=False,
        ),
    )
    lost += error_on_log(request, entries)
    facts = {
        "name": request.name,
        "pin": f"{request.name.replace('_', '-')}-table",
        "points": points,
        "losses": map(plain, lost),
    }
    return rendered("hal/table.hal", facts | {"units": settings}), lost


def points_of(
    entries: Mapping[float, np.ndarray], near_rest: float, settings: Settings
) -> list[tuple[float, float]]:
    """Return the points of the table, velocity ascending, in units of the machine; the entries at rest move to `near_rest` [m/s]."""
    points = []
    for way, side in entries.items():
        speeds = np.maximum(side[:, 0], near_rest)
        points += [
            (way * v / settings.position.si, way * f / settings.effort.si)
            for v, f in zip(speeds, side[:, 1], strict=True)
        ]
    return sorted((float(v), float(f)) for v, f in points)
