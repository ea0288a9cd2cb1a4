"""An identification, as a person at a terminal reads it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.cli.terminal import complain, say, show_table

if TYPE_CHECKING:
    from bristle.identification import Identification
    from bristle.prediction.following import Following
    from bristle.simulation import SimulationResult

__all__ = ["show_identification"]


def show_identification(identification: Identification, simulation: SimulationResult | None, following: Following | None = None) -> None:
    """Write parameters, the models compared, and what compensation gains; warnings go to the error stream."""
    from bristle.core.typography import with_unit
    from bristle.core.variable import unit_of
    from bristle.report.compensation import about_loop, gain_of
    from bristle.report.judgement import judged
    from bristle.report.log import break_away_table
    from bristle.report.messages import warnings_of, whole_sentence, why_effective
    from bristle.report.model_tables import comparison_table, parameter_table

    best = identification.best
    judgement = judged(best, identification.settings, following)
    say(f"{judgement.words}{': ' if judgement.reasons else ''}{'; '.join(judgement.reasons)}.")
    for diagnostic in best.diagnostics:
        if diagnostic.code == "delay_found":
            say(whole_sentence(diagnostic))
        elif diagnostic.code == "structure" and diagnostic.severity == "note":
            say(f"Parameters are effective: {why_effective(best)}, too small to matter; the report names it.")
    show_table(parameter_table(best))
    if len(identification.fits) > 1:
        show_table(comparison_table(identification, details=False))
    if identification.break_aways:
        show_table(break_away_table(identification.break_aways, best.plant.kind))
    held_out = f", {best.held_out.mean_percent:.3g} % on held-out {best.held_out.of}" if best.held_out else ""
    if best.position_rmse is not None:
        rmse = with_unit(best.position_rmse, unit_of("length", best.plant.kind))
        say(f"Position error {best.error_percent:.3g} % of the motion, {rmse} root mean square{held_out}.")
    elif best.loop_rmse is not None:
        rmse = with_unit(best.loop_rmse, unit_of("force", best.plant.kind))
        say(f"Effort error of the simulated loop {best.error_percent:.3g} %, {rmse} root mean square{held_out}.")
    else:
        friction = f"{best.friction_alone_error_percent:.3g} % of what friction takes of it"
        say(f"Force error {best.force_error_percent:.3g} % of the effort, {friction}{held_out}.")
    gain = gain_of(simulation) if simulation else None
    for sentence in about_loop(gain, following, best.plant.kind):
        say(sentence)
    for note in identification.notes:
        say(f"Note: {note}")
    for warning in warnings_of(best):
        complain(f"warning: {warning}")
