"""The explanation of the effort of a log, in words and tables."""

from bristle.core import unit_of, with_unit
from bristle.identification import Explanation, Part, interval_words, percent
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
    rows = [part_row(part, explanation) for part in explanation.parts]
    unit = unit_of("force", explanation.kind)
    facts = [
        (words, interval_words(*explanation.numbers[name]))
        for name, words in QUANTITIES.items()
        if name in explanation.numbers
    ]
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


def part_row(part: Part, explanation: Explanation) -> list[str]:
    """Return the row of a part: share, rms force and evidence."""
    rms = with_unit(part.rms, unit_of("force", explanation.kind))
    row = [part.label(explanation.kind), f"{percent(part.share)} %", rms]
    if part.evidence is None:
        return [*row, "", ""]
    return [*row, f"{percent(part.evidence.gain)} %", f"{part.evidence.z:.1f}"]
