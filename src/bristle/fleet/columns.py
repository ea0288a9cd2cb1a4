"""The columns of a fleet: what each is, its unit in SI, and how it is kept."""

from __future__ import annotations

from typing import Any

from bristle.fleet.plan import ENDS, Fleet, Quantity

__all__ = ["RUN", "described_columns", "numbers_of", "schema_of", "texts_of"]

RUN = {
    "run": "number of the log in the fleet",
    "folder": "folder that the log lay in",
    "log": "name of the log, with the table in it",
    "time_of_log": "when it was recorded, by its own clock",
    "status": "how it ended",
    "reason": "why it has no numbers",
    "diagnostics": "codes of the warnings about the fit",
}
OF_FIT = (
    Quantity("held_out_error", "", "error on held-out blocks, as a share of the effort"),
    Quantity("error", "", "what was made small, as a share"),
    Quantity("scatter", "", "standard deviation of the level of friction from reversal to reversal, as a share"),
    Quantity("temperature", "K", "mean of the column temperature"),
    Quantity("duration", "s", "length of the log"),
)
WITH_ENDS = ("scatter",)


def texts_of(fleet: Fleet) -> list[str]:
    """Return the columns of text."""
    own = [name for name in RUN if name not in ("run", "time_of_log")]
    return own + [f"{quantity.column}.status" for quantity in fleet.parameters.values()]


def numbers_of(fleet: Fleet) -> list[Quantity]:
    """Return the columns of numbers: each parameter with the ends of its interval, then what is known of the fit."""
    quantities = []
    for quantity in (*fleet.parameters.values(), *OF_FIT):
        quantities.append(quantity)
        if quantity not in OF_FIT or quantity.column in WITH_ENDS:
            quantities += [
                quantity._replace(column=f"{quantity.column}.{end}", description=f"{end} end of the 95 % interval of {quantity.column}")
                for end in ENDS
            ]
    return quantities


def schema_of(fleet: Fleet, pyarrow: Any) -> Any:
    """Return the schema of a block, units beside the numbers."""
    times = {"run": pyarrow.int64(), "time_of_log": pyarrow.timestamp("us")}
    fields = [pyarrow.field(name, times.get(name, pyarrow.string())) for name in RUN]
    statuses = {quantity.column: f"{quantity.column}.status" for quantity in fleet.parameters.values()}
    for quantity in numbers_of(fleet):
        fields.append(pyarrow.field(quantity.column, pyarrow.float64(), metadata={"unit": quantity.unit}))
        if quantity.column in statuses:
            fields.append(pyarrow.field(statuses[quantity.column], pyarrow.string()))
    return pyarrow.schema(fields)


def described_columns(fleet: Fleet) -> dict[str, dict[str, str]]:
    """Return what each column of a block is: its role, its unit in SI and what it means."""
    parameters = {quantity.column for quantity in fleet.parameters.values()}
    columns = {name: {"role": "run", "unit": "", "description": description} for name, description in RUN.items()}
    for quantity in numbers_of(fleet):
        role = "parameter" if quantity.column in parameters else "interval" if "." in quantity.column else "fit"
        columns[quantity.column] = {"role": role, "unit": quantity.unit, "description": quantity.description}
        if quantity.column in parameters:
            columns[f"{quantity.column}.status"] = {"role": "run", "unit": "", "description": "identified, held, at_edge or unidentifiable"}
    return columns
