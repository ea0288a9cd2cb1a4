"""The report of a simulated experiment: its variants side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from bristle.core.status import Status
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.report.best import closing_sentences, standing
from bristle.report.compensation import pair_in
from bristle.report.fronts.simulation import is_open, simulation_front
from bristle.report.loop_tables import component_table, direction_table, run_table, variant_table
from bristle.report.page import Picture, picture, render

if TYPE_CHECKING:
    from bristle.core.contracts import Model
    from bristle.core.experiment import Variant
    from bristle.prediction.following import Following
    from bristle.simulation.result import SimulationResult

__all__ = ["following_picture", "motion_picture", "simulation_report"]


def simulation_report(
    result: SimulationResult, *, command: str, provenance: Mapping[str, str], banner: str | None = None,
    warnings: Sequence[str] = (), doubts: Sequence[str] | None = None,
) -> str:  # fmt: skip
    """Return the report of a simulated experiment as one HTML page.

    Parameters
    ----------
    result : SimulationResult
        The variants of a loop, simulated.
    command : str
        The command that repeats it.
    provenance : mapping of str to str
        Versions, files, checksums.
    banner : str, optional
        What a reader must know before anything else.
    warnings : sequence of str
        What is to be said of the loops: poles and margins.
    doubts : sequence of str, optional
        The same in short; `warnings` by default.
    """
    variants, open_ = result.experiment.variants, is_open(result)
    pictures = motion_picture(result) if open_ else following_picture(result)
    figure = pictures.pop("motion", None) if open_ else _reversal_picture(result)
    return render(
        "simulation.html",
        provenance=provenance,
        command=command,
        banner=banner,
        front=simulation_front(result, warnings if doubts is None else doubts, figure),
        name=result.experiment.name,
        verdict=[*(f"{warning}." for warning in warnings), *_sentences(result)],
        is_open=open_,
        variants=variant_table(result),
        directions=None if open_ else direction_table(result),
        pictures=pictures,
        loops=[component_table(f"The parts of {variant.name}", _parts(variant)) for variant in variants],
        efforts=[f"{variant.name}: {variant.effort.description}" for variant in variants if variant.effort is not None],
        runs=run_table(variants),
    )


def _reversal_picture(result: SimulationResult) -> Picture | None:
    """Return the figure of the loop as it stands and the best one around the worst reversal."""
    from bristle.figures import has_completed, loops_at_reversal

    rank = standing(result)
    if rank is None or not has_completed(result):
        return None
    # Close up stand the two that differ in the friction fed forward alone: the lag of a loop would flatten both.
    pair, best = pair_in(result), rank.best.name
    near = (pair[0].name, best) if pair is not None and pair[1].name == best else (rank.base.name, best)
    names, close = (list(dict.fromkeys(group)) for group in ((rank.base.name, *near), near))
    return picture(
        "reversal", lambda: loops_at_reversal(result, names, close),
        f"Following error of {', '.join(names)} over time and at the worst reversal, and the effort there",
        "Following error over the whole run, close up at the worst reversal (shaded above), and the effort there"
        f"{'' if names == close else ', both of ' + ' and '.join(close)}.",
    )  # fmt: skip


def following_picture(result: SimulationResult, measured: Following | None = None) -> dict[str, Picture]:
    """Return the figure of the following error, where a variant completed, the measured one under them."""
    from bristle.figures import following_error, has_completed

    if not has_completed(result):
        return {}
    return {
        "following": picture(
            "following",
            lambda: following_error(result, _focus(result), None if measured is None else measured.error),
            "Following error and effort of each variant over time",
            f"Reference less encoder reading{', measured and simulated' if measured is not None else ''}: over time, "
            "as a distribution, and close up at a reversal (shaded above). "
            "What jumps where the reference reverses is friction; what follows the velocity is the lag of the "
            "position loop, or viscous friction that is not fed forward. Below, the effort that it takes.",
        )
    }  # fmt: skip


def motion_picture(result: SimulationResult) -> dict[str, Picture]:
    """Return the figure of what a given effort does, where a variant completed."""
    from bristle.figures import has_completed, open_loop

    if not has_completed(result):
        return {}
    return {
        "motion": picture(
            "motion", lambda: open_loop(result),
            "Position, velocity, friction and effort of each variant over time",
            "Where the velocity is zero and friction holds against the effort, the axis sticks.",
        )
    }  # fmt: skip


def _focus(result: SimulationResult) -> tuple[str, ...]:
    return tuple(variant.name for variant in pair_in(result) or ())


def _sentences(result: SimulationResult) -> list[str]:
    failed = [variant.name for variant in result.variants.values() if variant.status is Status.NOT_FINITE]
    lines = [f"{name}: {Status.NOT_FINITE.sentence}." for name in failed]
    unit = unit_of("length", result.experiment.kind)
    lines += [
        f"{variant.name}: moves by {with_unit(variant.motion.peak_to_peak, unit)} peak to peak."
        if variant.is_open
        else f"{variant.name}: following error {with_unit(variant.following_error.peak_to_peak, unit)} peak to peak, "
        f"{with_unit(variant.following_error.rms, unit)} root mean square."
        for variant in result.variants.values()
        if variant.name not in failed
    ]
    return lines + closing_sentences(result)


def _parts(variant: Variant) -> list[tuple[str, Model | None]]:
    if variant.effort is not None:
        return [("Plant", variant.plant), ("Friction", variant.friction), ("Sensor", variant.sensor)]
    return [
        ("Plant", variant.plant), ("Friction", variant.friction), ("Controller", variant.controller),
        ("Sensor", variant.sensor), ("Reference", variant.reference),
        ("Friction fed forward", variant.feedforward.friction),
    ]  # fmt: skip
