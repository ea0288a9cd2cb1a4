"""The steps of a run, each behind a gate: check, warm-up, record, excite, identify, load, refine, compare, keep."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from bristle.apps.tune.machine import (
    FrictionFeedforward,
    MachineRefusedError,
    MachineStoppedError,
    Recording,
    SavingMachine,
)
from bristle.apps.tune.run import MODEL, REFINED, REST, RESULTS, Run, cycles_of, noted, rms
from bristle.logs import Log
from bristle.prediction import first_gain
from bristle.prediction.excitation import excite
from bristle.report.compared import compare
from bristle.report.identified import identify
from bristle.report.judgement import ruling_of

# Test efforts, as shares of the largest effort.
OFFSETS = (0.0025, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16)
CLEAR = 2.0  # an answer of the loop to a test effort, as a multiple of its scatter
EVEN = 0.25  # smallest of the steps by equal test efforts, as a share of the largest
ANSWER = 0.3  # of the loop to a test effort, as a share of it
# Relative difference of two pairs of cycles of a warm axis, most pairs of a warm-up.
AGREE, WARM_UP = (0.03, 10)
QUIET = 0.05  # effort at rest that does not count, as a share of the effort in motion
SMALL = 0.1  # swing at rest that shows no answer of the loop, as a share of a count of the encoder
# Of records before and after: a drift and its curvature are those of both sides.
ORDER = (0, 1, 1, 0, 1, 0, 0, 1)
# Band of the settled error, as a share of the rms error without feedforward; time that it must last [s]
SETTLED, LASTS = (0.25, 0.05)
SPARE = 0.01  # of the ratio of the effort at the safe gain
# Allowed ratio of error, effort, noise and settling time, if it differs from 1, and in every case.
WORSE, CLEARLY_WORSE = (1.05, 1.5)
HUNTS = (
    0.25  # effort at rest, as a share of the effort in motion: the loop hunts without a feedforward
)
NOISIER = (
    3.0  # ratio of the effort at rest with and without the feedforward: the loop hunts with it
)
GAINS = (0.0, 0.25, 0.5, 1.0)
STAGE_CYCLES, RUN_IN = 3, 2  # of a stage; at the start of a record that is compared


class Step(NamedTuple):
    """A step: name, sentence, function, whether it moves the axis, whether its result is read from the journal when a run resumes."""

    name: str
    title: str
    act: Callable[[Run], None]
    moves: bool = True
    resumes: bool = False


def identity(run: Run) -> None:
    """Read identity and limits; refuse a machine that changed since the run began."""
    identified = dict(run.machine.identity())
    before = run.journal.last("done", step="identity")
    if before is not None and before["facts"]["identity"] != identified:
        changed = [
            name
            for name in before["facts"]["identity"]
            if before["facts"]["identity"][name] != identified.get(name)
        ]
        raise MachineRefusedError(
            "identity_changed",
            f"the machine differs from that of the run: {', '.join(changed)}",
            "Begin a new run",
        )
    limits = run.limits
    limited = {
        "following_error": limits.following_error,
        "effort": limits.effort,
        "travel": limits.travel,
    }
    run.finish(identity=identified, limits=limited, saves=isinstance(run.machine, SavingMachine))


def backup(run: Run) -> None:
    """Read everything that the run may write, twice."""
    state = dict(run.machine.state())
    if dict(run.machine.state()) != state:
        raise MachineRefusedError(
            "state_unstable",
            "two readings of the parameters of the machine differ",
            "Stop what else writes them",
        )
    run.backup = run.finish(state=state, writes=run.machine.writes())["facts"]["state"]


def check(run: Run) -> None:
    """Arm the guard, measure the noise at rest, prove that a test effort reaches the motor, and that the guard trips."""
    run.arm()
    still = run.record("rest", run.rest(2.0))
    answer = _answer(run)
    _prove_guard(run, float(still.position[-1]))
    run.record("rest_after_check", run.rest(1.0))
    run.finish(noise_effort=rms(still.effort), noise_position=rms(still.position), **answer)


def _answer(run: Run) -> dict[str, Any]:
    """Return the answer of the axis to the smallest test effort that shows: motion along the effort, or loop against it."""
    count, unrest = run.axis.resolution or 0.0, False
    for share in OFFSETS:
        offset = share * run.limits.effort
        steps, loop, scatter = _pushed(run, offset)
        moved = 0.5 * float(np.mean(steps))
        # Equal steps to and fro are an answer; an axis that does not rest makes other steps.
        moves = abs(moved) > 0.5 * count and np.min(steps * np.sign(moved)) > EVEN * np.max(
            np.abs(steps)
        )
        net = 1.0 + loop / offset
        answers = abs(net) < ANSWER and abs(loop) > CLEAR * scatter
        if moves and moved < 0.0 and net > ANSWER:
            raise MachineRefusedError(
                "wrong_sign",
                "a positive test effort moves the axis backward",
                "Reverse the sign of the effort",
            )
        # An integral action that opposes more than the test effort reverses the net effort, and the axis follows it.
        if answers or (moves and (moved > 0.0 or net < -ANSWER)):
            return {"test_effort": offset, "moved": moved, "loop_answer": loop / offset}
        unrest = unrest or bool(np.ptp(steps) > 4.0 * count)
    if unrest:
        raise MachineRefusedError(
            "hunts",
            "the axis does not rest: equal test efforts move it differently",
            "Lower the integral gain, or add damping, until the axis rests",
        )
    raise MachineRefusedError(
        "no_effect",
        f"a test effort of {OFFSETS[-1]:.0%} of the limit moves nothing and changes nothing in the loop",
        "The effort does not reach the motor: the drive must be in a mode that accepts an effort",
    )


def _pushed(run: Run, offset: float) -> tuple[np.ndarray, float, float]:
    """Return the steps of position by test efforts to and fro, the answer of the loop to one, and the scatter of this answer."""
    levels = []
    for side in 3 * (1.0, -1.0):
        run.set(offset=side * offset)
        recording = run.record("test_effort", run.rest(0.5))
        half = recording.position.size // 2
        levels.append((np.mean(recording.position[half:]), np.mean(recording.effort[half:])))
    run.set()
    # Friction has memory: the first effort differs from the loops behind it, which close.
    position, effort = np.array(levels[1:]).T
    ahead, back = effort[1::2], effort[2::2]
    scatter = max(float(np.ptp(ahead)), float(np.ptp(back)))
    return (
        np.diff(position) * (1.0, -1.0, 1.0, -1.0),
        0.5 * float(np.mean(ahead) - np.mean(back)) - offset,
        scatter,
    )


def _prove_guard(run: Run, position: float) -> None:
    """Refuse a machine whose guard does not trip outside its travel."""
    outside = position + 0.1 * (run.limits.travel[1] - run.limits.travel[0])
    run.arm(replace(run.limits, travel=(outside, outside + 1.0)))
    try:
        run.machine.record(run.rest(0.2), lambda: None)
    except MachineStoppedError as stopped:
        if stopped.reason != "travel":
            raise
    else:
        raise MachineRefusedError(
            "guard_fails",
            "the guard of the machine does not trip outside its travel",
            "Do not run this machine",
        )
    run.arm()


def warm_up(run: Run) -> None:
    """Repeat the motion until two pairs of cycles agree; refuse an effort that does negative work, which friction cannot."""
    pairs: list[tuple[float, float]] = []
    while len(pairs) < WARM_UP:
        recording = run.record("warm_up", run.motion(2))
        if (
            np.sum(
                cycles_of(run, recording.effort) * cycles_of(run, np.gradient(recording.position))
            )
            < 0.0
        ):
            raise MachineRefusedError(
                "wrong_sign",
                "the effort acts against the motion: it does negative work in each cycle",
                "Reverse the sign of the effort",
            )
        pairs.append((rms(recording.effort), rms(recording.error)))
        if len(pairs) > 1 and all(
            abs(new - old) <= AGREE * old for old, new in zip(*pairs[-2:], strict=True)
        ):
            break
    run.finish(cycles=2 * len(pairs), effort=pairs[-1][0], error=pairs[-1][1])


def before(run: Run) -> None:
    """Record the user's motion; refuse an axis that hunts at rest."""
    recording = run.record("before", run.motion(run.file.cycles))
    at_rest = _at_rest(run, recording.effort)
    moving = rms(cycles_of(run, recording.effort))
    if at_rest > HUNTS * moving:
        raise MachineRefusedError(
            "hunts",
            f"the effort at rest swings by {at_rest / moving:.0%} of the effort in motion: the loop hunts",
            "Lower the integral gain, or add damping, until the axis rests",
        )
    run.finish(error=rms(cycles_of(run, recording.error, 1)), effort=moving, noise=at_rest)


def excitation(run: Run) -> None:
    """Plan the excitation on a first model of the recorded motion, within the limits, and record it."""
    axis, start = run.axis, float(run.file.cycle[0])
    motion = excite(
        axis,
        duration=run.options.duration,
        start=start,
        log=run.log("before"),
        rehearsed=False,
        draws=0,
    ).motion
    rest = run.rest(REST)
    recording = run.record("excitation", np.concatenate([rest, motion.position, rest]))
    run.finish(duration=recording.position.size * run.sample_time, error=rms(recording.error))


def identification(run: Run) -> None:
    """Identify the axis; stop without a usable feedforward."""
    facts = _identified(run, "excitation", RESULTS)
    if not facts["usable"]:
        raise MachineRefusedError(
            "no_usable_model",
            f"{facts['verdict']}: {'; '.join(facts['reasons'][:2])}",
            "The records of this run are in the folder records",
        )
    run.finish(**facts)


def _identified(run: Run, record: str, folder: str) -> dict[str, Any]:
    """Identify the axis from a record, and save the results in a folder."""
    run.tell("identifying")
    result = identify(
        run.log(record), run.options.models, axis=run.axis, draws=run.options.draws
    ).finished
    second = result.second_pass
    ruling = ruling_of(result)
    result.save(run.folder / folder, force=True)
    run.note(f"{folder}/{MODEL}")
    return {
        "model": result.best.name,
        "verdict": ruling.words,
        "reasons": list(ruling.reasons),
        "error_percent": result.best.friction_alone_error_percent,
        "lead": max(0.0, -float(result.treatment.get("delay", 0.0))),
        "proposals": [line._asdict() for line in second.lines]
        if second is not None and second.taken
        else [],
        "usable": bool(first_gain(result.best)),
        "results": folder,
    }


def stages(run: Run) -> None:
    """Load the feedforward at gain 0, raise the gain in stages, and stop where the axis hunts or errs more."""
    run.finish(**_raised(run, run.facts["identification"], ""))


def _raised(run: Run, identified: dict[str, Any], name: str) -> dict[str, Any]:
    """Load an identified feedforward, and raise its gain in stages; return the safe gain and its error, and all stages."""
    run.load(_feedforward(run, identified))
    table: list[dict[str, float]] = []
    worse: dict[str, float] | None = None
    for gain in GAINS:
        stage = _stage(run, gain, table, name)
        if table and stage["error"] > WORSE * table[0]["error"]:
            worse = stage
            break
        most = (run.file.effort_ratio - SPARE) * table[0]["effort"] if table else np.inf
        if stage["effort"] > most:
            # The effort rises with the gain: the safe gain keeps the effort of the loop within its limit.
            low = table[-1]
            share = (most - low["effort"]) / (stage["effort"] - low["effort"])
            table.append(
                _stage(run, low["gain"] + max(share, 0.0) * (gain - low["gain"]), table, name)
            )
            break
        table.append(stage)
    allowed = [
        stage for stage in table if stage["effort"] <= run.file.effort_ratio * table[0]["effort"]
    ]
    best = min(allowed, key=lambda stage: stage["error"])
    run.set()
    if best["gain"] < GAINS[1] and worse:
        ratio = worse["error"] / table[0]["error"]
        raise MachineRefusedError(
            "worse",
            f"at gain {worse['gain']:g} the following error is {ratio:.0%} of that without it",
            "Check the sign of the effort",
        )
    if best["gain"] < GAINS[1]:
        raise MachineRefusedError(
            "no_gain",
            "no gain of the feedforward reduces the following error without a larger effort",
            "Allow it: effort_ratio = 1.2",
        )
    return {"gain": best["gain"], "error": best["error"], "stages": table}


def refinement(run: Run) -> None:
    """Repeat the excitation with the feedforward, identify again, and go on with the better of both feedforwards.

    An axis that sticks does not move as planned. With the feedforward it follows, and its record shows friction at low speed.
    """
    first = run.facts["stages"]
    run.set(gain=first["gain"])
    run.record("refinement", _to_refine(run))
    run.set()
    used, identified = run.facts["identification"], _identified(run, "refinement", REFINED)
    try:
        best = (
            min(first, _raised(run, identified, "refined_"), key=itemgetter("error"))
            if identified["usable"]
            else first
        )
    except MachineRefusedError:
        best = first
    if best is first:
        run.load(_feedforward(run, used))
    else:
        used = identified
    run.finish(**used, gain=best["gain"], error=best["error"])


def _to_refine(run: Run) -> np.ndarray:
    """Return the reference of the excitation, and behind it the user's motion."""
    excitation = run.log("excitation").reference
    assert excitation is not None
    return np.concatenate([excitation.values, run.motion(STAGE_CYCLES)])


def _stage(run: Run, gain: float, table: list[dict[str, float]], name: str) -> dict[str, float]:
    """Record a gain; refuse it where the axis hunts."""
    run.set(gain=gain)
    now = _stage_record(run, gain, name)
    first = table[0] if table else now
    most = NOISIER * first["noise"] + QUIET * first["effort"]
    if now["noise"] > most:  # hunting lasts; a single slip at rest is not hunting
        now = _stage_record(run, gain, name)
    if now["noise"] > most:
        raise MachineRefusedError(
            "hunts_with_feedforward",
            f"at gain {gain:g} the effort at rest swings by {now['noise']:.3g} in SI",
        )
    return now


def _stage_record(run: Run, gain: float, name: str) -> dict[str, float]:
    recording = run.record(f"{name}stage_{round(100 * gain)}", run.motion(STAGE_CYCLES))
    error, effort = (
        rms(cycles_of(run, signal, 1)) for signal in (recording.error, recording.effort)
    )
    return {
        "gain": gain,
        "error": error,
        "effort": effort,
        "noise": _at_rest(run, recording.effort),
    }


def _feedforward(run: Run, identified: Mapping[str, Any]) -> FrictionFeedforward:
    """Return the feedforward of an identified model."""
    from bristle.files import read_model

    path = noted(run.journal, f"{identified['results']}/{MODEL}")
    plant, friction, _ = read_model(path)
    name = f"bristle_{hashlib.sha256(path.read_bytes()).hexdigest()[:8]}"
    assert plant is not None
    return FrictionFeedforward(
        path.parent, name, plant, friction, identified["lead"], run.limits.effort
    )


def cycles_compared(cycles: int) -> int:
    """Return the number of cycles of a record that is compared, without those that run in."""
    return max(cycles // 2 - 1, 2)


def comparison(run: Run) -> None:
    """Record before and after alternately: the change of each quantity with its interval, without thermal drift."""
    gain, motion = (
        run.facts["refinement"]["gain"],
        run.motion(cycles_compared(run.file.cycles) + RUN_IN),
    )
    records: tuple[list[Recording], list[Recording]] = ([], [])
    logs: tuple[list[Log], list[Log]] = ([], [])
    for side in ORDER:
        run.set(gain=side * gain)
        name = f"{('before', 'after')[side]}_{len(logs[side]) + 1}"
        records[side].append(run.record(name, motion, skip=RUN_IN))
        logs[side].append(run.log(name))
    run.set()
    run.compared = compared = compare(*logs, axis=run.axis)
    ratios = {
        "noise at rest": _ratio(*_noises(run, records)),
        "settling time": _ratio(
            *([_settling(run, recording) for recording in side] for side in records)
        ),
    }
    numbers = {name: change.as_data() for name, change in compared.changes.items()}
    run.finish(changes=numbers, ratios=ratios, helped=compared.helped, gain=gain)


def verdict(run: Run) -> None:
    """Keep the feedforward if the error is lower with its interval and nothing else is worse."""
    facts = run.facts["comparison"]
    if not facts["helped"]:
        raise MachineRefusedError(
            "not_better", "the following error is not significantly lower with the feedforward"
        )
    worse = [
        name
        for name, ratio in facts["ratios"].items()
        if (ratio["interval"][0] > 1.0 and ratio["value"] > WORSE) or ratio["value"] > CLEARLY_WORSE
    ]
    error = facts["changes"]["following_error.rms"]["before"]
    for name, change in facts["changes"].items():
        most = change["before"] * (run.file.effort_ratio if name.startswith("effort") else WORSE)
        # An axis that lags on its whole way may have a small error where it reverses.
        if name.startswith("reversals"):
            most = max(most, error)
        is_judged = name.startswith(("following_error", "reversals", "effort"))
        if is_judged and change["verdict"] == "higher" and change["after"] > most:
            worse.append(name)
    if worse:
        raise MachineRefusedError(
            "something_worse", f"the feedforward lowers the error, but raises: {', '.join(worse)}"
        )
    run.set(gain=facts["gain"])
    run.machine.keep()
    run.journal.write(
        run.step,
        "kept",
        state=dict(run.machine.state()),
        results=run.facts["refinement"]["results"],
    )


def _ratio(before: Sequence[float], after: Sequence[float]) -> dict[str, Any]:
    """Return the ratio of the geometric means of two sides with its 95 % interval by Welch, each record a replicate."""
    from scipy.special import stdtrit

    sides = np.log(before), np.log(after)
    parts = np.array([np.var(side, ddof=1) / side.size for side in sides])
    freedom = parts.sum() ** 2 / max(
        sum(parts**2 / [side.size - 1 for side in sides]), np.finfo(float).tiny
    )
    change, half = (
        np.mean(sides[1]) - np.mean(sides[0]),
        stdtrit(max(freedom, 1.0), 0.975) * np.sqrt(parts.sum()),
    )
    return {
        "value": float(np.exp(change)),
        "interval": [float(np.exp(change - half)), float(np.exp(change + half))],
    }


def _noises(run: Run, sides: Sequence[list[Recording]]) -> list[list[float]]:
    """Return the rms effort at rest of each record, at least the share and the answer to an encoder count that do not count."""
    count = run.axis.resolution or 0.0
    efforts, swings = (
        [[_at_rest(run, getattr(own, name)) for own in side] for side in sides]
        for name in ("effort", "position")
    )
    effort, swing = np.ravel(efforts), np.ravel(swings)
    moves = swing > SMALL * count
    of_a_count = (
        float(np.min(count * effort[moves] / swing[moves], initial=np.inf)) if moves.any() else 0.0
    )
    least = max(QUIET * rms(sides[0][0].effort), of_a_count)
    return [[max(effort, least) for effort in side] for side in efforts]


def _at_rest(run: Run, signal: np.ndarray) -> float:
    """Return the rms of a signal in the second halves of the rests before and behind a motion, without their trends."""
    from scipy.signal import detrend

    rest, half = run.rest(REST).size, run.rest(0.5 * REST).size
    windows = np.stack([signal[rest - half : rest], signal[-half:]], axis=1)
    return float(np.sqrt(np.mean(detrend(windows, axis=0) ** 2)))


def _settling(run: Run, recording: Recording) -> float:
    """Return the time from a stop until the error lasts in a quarter of its rms without feedforward, a geometric mean of all stops [s]."""
    still = np.flatnonzero(np.diff(recording.reference, prepend=recording.reference[0]) == 0.0)
    lasts = max(round(LASTS / run.sample_time), 1)
    band = max(SETTLED * run.facts["before"]["error"], 2.0 * (run.axis.resolution or 0.0))
    times = []
    # The record begins with a rest that follows no motion.
    for stop in np.split(still, np.flatnonzero(np.diff(still) > 1) + 1)[1:]:
        if stop.size >= 2 * lasts:
            inside = (
                np.convolve(np.abs(recording.error[stop]) <= band, np.ones(lasts), "valid")
                >= lasts - 0.5
            )
            times.append(np.argmax(inside) if inside.any() else stop.size)
    return run.sample_time * float(np.exp(np.mean(np.log(np.maximum(times, lasts)))))


STEPS = (
    Step("identity", "Read identity and limits of the machine", identity, moves=False),
    Step("backup", "Back up everything that the run may write", backup, moves=False),
    Step("check", "Arm the guard; a small test effort at rest must reach the motor", check),
    Step("warm_up", "Repeat the motion until its cycles agree", warm_up),
    Step("before", "Record the motion without feedforward", before, resumes=True),
    Step("excitation", "Plan and record an excitation within the limits", excitation, resumes=True),
    Step("identification", "Identify the friction", identification, moves=False, resumes=True),
    Step("stages", "Raise the gain of the feedforward: 0, 0.25, 0.5, 1", stages),
    Step(
        "refinement",
        "Repeat the excitation with the feedforward, identify again, and use the better model",
        refinement,
    ),
    Step("comparison", "Record before and after alternately", comparison),
    Step("verdict", "Keep the feedforward, or restore the machine", verdict, moves=False),
)
