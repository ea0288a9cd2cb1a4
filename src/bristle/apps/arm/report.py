"""Report of an arm: its bodies, base parameters with intervals, and the files for other programs."""

from collections.abc import Mapping
from typing import Any

from bristle.apps.arm import Arm
from bristle.core import number, with_unit
from bristle.report.cards import Step
from bristle.report.page import Front, Ruling, Section, about, report_page
from bristle.report.table import Table, percent_text
from bristle.simulation import Prediction

IN_SUM = " (only in a sum)"
UNITS = {"m": "kg", "mc": "kg·m", "I": "kg·m²", "J": "kg·m²"}


def arm_summary(arm: Arm) -> dict[str, Any]:
    """Return the dynamics of an arm in numbers, in SI."""
    dynamics = arm.dynamics
    rows = zip(
        arm.tables,
        dynamics.errors.tolist(),
        dynamics.bodies.tolist(),
        dynamics.rotors.tolist(),
        strict=True,
    )
    in_sums = dynamics.rotors_in_sums
    return {
        "joints": {
            name: {"error": error, "body": body, "rotor": rotor, "rotor_in_sum": name in in_sums}
            for name, error, body, rotor in rows
        },
        "base_parameters": {
            entry.name: {
                "value": entry.value,
                "half_width": entry.half_width,
                "sum_of": dict(entry.members),
            }
            for entry in dynamics.base
        },
    }


def joints_table(arm: Arm) -> Table:
    """Return the error of each joint with the bodies of the arm and any friction, its body and its rotor."""
    rows = [
        (
            name,
            percent_text(100.0 * error),
            number(body[0]),
            *(number(value, 1e-3) for value in body[1:4] / body[0]),
            number(rotor) + (IN_SUM if name in arm.dynamics.rotors_in_sums else ""),
        )
        for name, error, body, rotor in zip(
            arm.tables, arm.dynamics.errors, arm.dynamics.bodies, arm.dynamics.rotors, strict=True
        )
    ]
    heads = (
        "Joint",
        "Error without a friction model",
        "Mass [kg]",
        "Centre x [m]",
        "y [m]",
        "z [m]",
        "Rotor inertia [kg·m²]",
    )
    return Table("The bodies", heads, rows)


def base_table(arm: Arm) -> Table:
    """Return the base parameters with their intervals and members."""
    rows = []
    for entry in arm.dynamics.base:
        unit = UNITS[entry.name.rpartition(".")[2].partition("_")[0]]
        members = " ".join(
            f"{'+' if factor > 0 else '−'} {number(abs(factor), digits=3)} {name}"
            for name, factor in entry.members
        )
        rows.append(
            (
                entry.name,
                number(entry.value, entry.half_width),
                number(entry.half_width, digits=2),
                unit,
                members.removeprefix("+ "),
            )
        )
    return Table(
        "The base parameters", ("Name", "Value", "Half-width (95 %)", "Unit", "Sum of"), rows
    )


def arm_sentence(arm: Arm) -> str:
    """Return where the bodies are, and the joints in which bristle found a spring or a cable."""
    text = "The report shows the bodies of the arm and their base parameters."
    return f"{text} {_springs(arm)}" if arm.pulled else text


def _springs(arm: Arm) -> str:
    return f'The log shows the force of a spring or cable on {", ".join(arm.pulled)}. The model contains it (`plant.spring = "cubic"`).'


def arm_sections(arm: Arm) -> list[Section]:
    """Return the sections of the report on an arm."""
    text = (
        "The efforts determine the base parameters, which are sums of the parameters of the bodies. The bodies below have these sums, "
        f"positive masses, and otherwise the values of the robot file. A rotor inertia{IN_SUM} has no value of its own: read the sum."
    )
    texts = [text, _springs(arm)] if arm.pulled else [text]
    return [Section("arm", "The arm", [*texts, joints_table(arm), base_table(arm)], "Arm")]


def arm_front(front: Front, table: Table, errors: Mapping[str, float]) -> Front:
    """Return the first screen of a fleet as that of an arm, with a row per joint and the held-out error of each."""
    name = max(errors, key=errors.__getitem__, default="")
    title = f"Largest model error: {percent_text(100.0 * errors[name])} ({name})" if name else ""
    step = Step(
        "Predict another log of the arm",
        f"bristle predict {front.heading.partition(':')[0]} OTHER.csv --out prediction",
    )
    return front._replace(
        heading=front.heading.replace("a fleet", "an arm"),
        title=title,
        basis="(held out)",
        cards=(),
        table=table,
        next=step,
    )


def arm_prediction(
    joints: Mapping[str, Mapping[str, Any]],
    predictions: Mapping[str, Prediction],
    name: str,
    log: str,
    command: str,
) -> tuple[dict[str, Any], Table, str]:
    """Return the predictions of all joints of an arm in numbers, as a table and as a page; the verdict is that of the worst joint."""
    levels = ("no", "with_care", "usable")
    worst = min((entry["verdict"]["level"] for entry in joints.values()), key=levels.index)
    words = {
        "no": "The model of a joint is not valid here",
        "with_care": "The model is valid, with care",
        "usable": "The model is valid",
    }
    reasons = [
        f"{name}: {'; '.join(entry['verdict']['reasons'])}"
        for name, entry in joints.items()
        if entry["verdict"]["level"] != "usable"
    ]
    completed = all(entry["completed"] for entry in joints.values())
    ruling, table = Ruling(worst, words[worst], tuple(reasons)), _predicted_table(joints)
    text = "The bodies of the arm give the effort along this log. The folder of each joint contains its report."
    percents = {name: entry["metrics"]["force_error_percent"] for name, entry in joints.items()}
    known = {name: percent for name, percent in percents.items() if percent is not None}
    largest = max(known, key=known.__getitem__, default="")
    title = (
        f"Largest prediction error: {percent_text(known[largest])} of the effort ({largest})"
        if largest
        else "No effort to compare"
    )
    front = Front(
        f"{name}: is the model valid?",
        about(f"log {log}", f"{len(joints)} joints"),
        ruling,
        title=title,
        table=table,
    )
    provenance = next(iter(joints.values()))["provenance"]
    drawn = {
        name: one
        for name, one in predictions.items()
        if one.effort is not None and one.effort_predicted is not None
    }
    facts = {"joints": drawn or None, "kind": next(iter(joints.values()))["kind"]}
    page = report_page(
        "arm",
        facts,
        front,
        [Section("joints", "The joints", [text])],
        command=command,
        provenance=provenance,
    )
    return (
        {"joints": dict(joints), "verdict": ruling.as_data(), "completed": completed},
        table,
        page,
    )


def _predicted_table(joints: Mapping[str, Mapping[str, Any]]) -> Table:
    """Return the error of the predicted effort of each joint, and the share of the effort inside its band."""
    rows = []
    for name, entry in joints.items():
        metrics, inside = entry["metrics"], entry["inside_band_percent"]
        percent, rmse = metrics["force_error_percent"], metrics["force_rmse"]
        texts = [
            "–" if value is None else text(value)
            for value, text in ((percent, percent_text), (inside, percent_text))
        ]
        error = "–" if rmse is None else with_unit(rmse, metrics["force_unit"])
        rows.append((name, texts[0], error, texts[1], entry["verdict"]["words"]))
    heads = ("Joint", "Effort error", "rms", "Effort inside the 95 % band", "Verdict")
    return Table("Prediction of the other log", heads, rows).without_empty_columns()
