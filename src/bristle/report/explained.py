"""The explanation of the effort of a log, in words and tables."""

from bristle.core import number, unit_of, with_unit
from bristle.identification import Explanation
from bristle.report.table import Table

QUANTITIES = {
    "M": "Inertia",
    "F_C": "Coulomb friction, mean over the motion",
    "F_C_and_cable": "Coulomb friction and limit of the cable",
    "F_v": "Viscous friction",
    "delay": "Delay of the effort",
}


def explanation_parts(explanation: Explanation) -> list[str | Table]:
    """Return the verdict, the tables and the notes for the terminal."""
    notes = [f"Note: {note}" for note in explanation.notes]
    return [f"Effort: {explanation.verdict}.", *tables_of(explanation), *notes]


def tables_of(explanation: Explanation) -> list[Table]:
    """Return the table of the parts and the table of the numbers."""
    heads = ("Force", "Share", "Rms", "Gain", "z")
    unit = unit_of("force", explanation.kind)
    rows = list[list[str]]()
    for part in explanation.parts:
        row = [part.label(explanation.kind), percent(part.share), with_unit(part.rms, unit)]
        evidence = ["", ""]
        if part.evidence is not None:
            evidence = [percent(part.evidence.gain), f"{part.evidence.z:.1f}"]
        rows.append([*row, *evidence])
    facts = list[tuple[str, str]]()
    for name, (value, unit_of_value) in explanation.numbers.items():
        text = "unknown"
        if value is not None:
            text = value.text(unit_of_value)
        facts.append((QUANTITIES[name], text))
    facts += [
        ("Rms effort", with_unit(explanation.effort, unit)),
        ("Rms inertial force", with_unit(explanation.inertia, unit)),
        ("Unexplained, rms", with_unit(explanation.unexplained, unit)),
        ("Error of held-out parts, rms", with_unit(explanation.floor, unit)),
    ]
    return [
        Table("Forces without inertia", heads, rows).without_empty_columns(),
        Table("Numbers", ("Quantity", "Value"), facts),
    ]


def percent(share: float) -> str:
    """Return a share as a percentage."""
    return f"{number(100.0 * share, digits=2)} %"
