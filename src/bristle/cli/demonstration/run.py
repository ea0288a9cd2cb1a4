"""The whole workflow on the simulated axis, with a folder of results."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from bristle.cli.demonstration import axis_simulated
from bristle.core import Progress, between, content_of
from bristle.files import Results, read_log
from bristle.prediction import following_of, predict
from bristle.report.identified import Outcome, identify
from bristle.simulation import Prediction, compensation_experiment, simulate

BANNER = "A simulated axis. Its friction has thirty elements that slip in turn; no fitted model has this structure."
# Seeds of the two motions.
FITTED = 1
UNSEEN = 2


@dataclass(frozen=True)
class Demonstration:
    """Results of the demonstration: the models, the prediction of the unseen log, the loop of the simulated axis."""

    outcome: Outcome
    prediction: Prediction
    summary: Mapping[str, object]


def run(folder: Results, *, command: str, progress: Progress | None = None) -> Demonstration:
    """Simulate an axis, identify it, predict an unseen log, compensate it, and write the results into `folder`.

    The folder also contains the axis file and both logs for other commands. The results state `command`.
    """

    def at(share: float, text: str) -> None:
        if progress is not None:
            progress(share, text)

    at(0.0, "running the simulated axis")
    folder.write("axis.toml", Path(axis_simulated.AXIS_FILE).read_bytes())
    axis_simulated.write_log(folder / "log.csv", FITTED)
    axis_simulated.write_log(folder / "unseen.csv", UNSEEN)
    axis = axis_simulated.axis()
    log = read_log(folder / "log.csv", axis)
    unseen = read_log(folder / "unseen.csv", axis)
    identification = identify(log, axis=axis, progress=between(at, 0.1, 0.8)).finished
    best = identification.best
    at(0.8, "predicting the second log")
    prediction = predict(best.plant, best.friction, unseen, axis, "closed-loop")
    at(0.83, "compensating the simulated axis")
    assert log.reference is not None
    simulation = simulate(
        compensation_experiment(
            axis_simulated.plant(),
            axis_simulated.friction(),
            best.friction,
            axis.controller,
            log.reference.values,
            log.sample_time,
            resolution=axis.resolution or 0.0,
            effort_limit=axis.effort_limit or float("inf"),
            rule=identification.compensation.rule,
            name=axis.name,
        )
    )
    following = following_of(log, simulation, identification.settings)
    at(0.85, "writing the report")
    outcome = identification.outcome_with(
        command=command,
        banner=BANNER,
        loop=(simulation, prediction, following),
        files={"axis": content_of(folder / "axis.toml")},
    )
    outcome.write(folder, simulated=True)
    return Demonstration(outcome, prediction, outcome.summary | {"simulated": True})
