"""What an axis file may say: its tables and keys, before units are looked at."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field

from bristle.core.dimensions import AxisKind, kind_called
from bristle.core.transmission import Side
from bristle.files.schema import ColumnName, Quantity, Strict

__all__ = ["AxisFile", "ColumnEntry", "InjectedEntry", "long_form"]


Harmonic = Annotated[int, Field(ge=1, le=10_000)]


def _no_truth_value(value: Any) -> Any:
    """Refuse what Python takes for a number, and nobody for a sign."""
    if isinstance(value, bool):
        raise ValueError("1 or -1")
    return value


class ColumnEntry(Strict):
    """One channel: which column it is, in what unit, with what sign, measured where."""

    column: ColumnName
    unit: str | None = None
    sign: Annotated[Literal[1, -1], BeforeValidator(_no_truth_value)] = 1
    side: Side | None = None
    optional: bool = False


def long_form(value: Any) -> Any:
    """Take a bare name of a column for an entry that says no more."""
    return {"column": value} if isinstance(value, (str, int)) and not isinstance(value, bool) else value


Entry = Annotated[ColumnEntry, BeforeValidator(long_form)]


class Columns(Strict):
    """The channels of the log; what else stands there is what surrounds the axis, for slots."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Entry] = Field(init=False)  # type: ignore[assignment]

    time: Entry | None = None
    position: Entry | None = None
    velocity: Entry | None = None
    effort: Entry | None = None
    reference: Entry | None = None
    following_error: Entry | None = None


class InjectedEntry(Strict):
    """A known input of the loop: effort for one unit of the column."""

    column: ColumnName
    gain: Quantity
    unit: str | None = None
    optional: bool = False


class KnownEntry(Strict):
    """A column of the log that an identified coefficient makes an effort of."""

    column: ColumnName
    name: Annotated[str, Field(pattern=r"^\w+$")] | None = None
    optional: bool = False


class CoggingEntry(Strict):
    """What of the effort comes back with every turn of something."""

    turn: Literal["motor", "screw"] = "motor"
    harmonics: Annotated[list[Harmonic], Field(max_length=200)] | Literal["identify"] = "identify"


class EffortEntry(Strict):
    """What turns the drive's own numbers into a force or a torque."""

    force_constant: str | None = None
    torque_constant: str | None = None
    constant: str | None = None
    rated: str | None = None
    limit: Quantity | None = None
    held: bool | None = None
    hold: Literal["zero", "linear", "band_limited"] | None = None
    lag: Quantity = 0.0
    periodic: bool | None = None


class TransmissionEntry(Strict):
    """What lies between motor and load."""

    gear_ratio: Annotated[float, Field(gt=0)] | None = None
    lead: Quantity | None = None


class PlantEntry(Strict):
    """What is known of what moves."""

    model: Literal["inertia", "oscillator"] = "inertia"
    stiffness: Quantity | None = None
    damping: Quantity | None = None
    mass: Quantity | None = None
    inertia: Quantity | None = None
    offset: Quantity = "identify"
    presliding: Quantity | None = None
    nominal_load: Quantity | None = None
    gravity: Literal["link"] | None = None


class EncoderEntry(Strict):
    """The position sensor."""

    resolution: Quantity | None = None
    counts_per_rev: Annotated[float, Field(gt=0)] | None = None
    side: Side | None = None


class LogEntry(Strict):
    """Where in the file the log is."""

    table: Annotated[str, Field(min_length=1)] | None = None
    start: Literal["rest", "moving", "cycle"] = "moving"
    span: Annotated[list[Quantity], Field(min_length=2, max_length=2)] | None = None


class TimingEntry(Strict):
    """Sample time and delay of the channels."""

    sample_time: Quantity | None = None
    sample_rate: Quantity | None = None
    delay: Quantity | None = None


class LimitsEntry(Strict):
    """How fast and how far the axis may go."""

    velocity: Quantity | None = None
    acceleration: Quantity | None = None
    jerk: Quantity | None = None
    stroke: Annotated[list[Quantity], Field(min_length=2, max_length=2)] | None = None


class IdentificationEntry(Strict):
    """How the log is filtered before a model is fitted."""

    cutoff: Quantity | None = None
    decimation: Annotated[int, Field(ge=1)] | None = None
    rests: Literal["drop", "keep"] = "drop"
    method: Literal["inverse_dynamics", "output_error"] = "inverse_dynamics"
    loop: Literal["open", "closed"] | None = None
    global_search: bool = False
    settings: dict[str, Quantity] = Field(default_factory=dict)


class AxisFile(Strict):
    """An axis file as a whole."""

    schema_version: Literal[1] = Field(alias="schema")
    name: str = "axis"
    kind: Annotated[AxisKind, BeforeValidator(kind_called)]
    log: LogEntry = LogEntry()
    columns: Columns
    effort: EffortEntry = EffortEntry()
    injected: list[InjectedEntry] = Field(default_factory=list)
    known: list[KnownEntry] = Field(default_factory=list)
    cogging: list[CoggingEntry] = Field(default_factory=list)
    transmission: TransmissionEntry = TransmissionEntry()
    plant: PlantEntry = PlantEntry()
    encoder: EncoderEntry = EncoderEntry()
    timing: TimingEntry = TimingEntry()
    limits: LimitsEntry = LimitsEntry()
    identification: IdentificationEntry = IdentificationEntry()
    controller: dict[str, Any] | None = None
