"""`bristle tune` on axes simulated without bristle: gain, restoration after kills, and coverage of the claimed intervals.

python -m benchmarks.tune gain [COUNT]        random axes from log to kept feedforward
python -m benchmarks.tune kills [COUNT]       runs killed at a random entry of the journal
python -m benchmarks.tune intervals [COUNT]   claimed intervals of a change whose long-run value is known
python -m benchmarks.tune linuxcnc [COUNT [FIRST]]   random axes in LinuxCNC's HAL
python -m benchmarks.tune hal_kills [EACH]    runs in LinuxCNC's HAL killed behind each line of the journal, or each EACHth
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import detrend
from tests.apps.tune.bench import KINDS, Bench, Motion, Plant, drawn
from tests.apps.tune.conftest import OPTIONS, begun, killed
from tests.apps.tune.linuxcnc.session import axis as linuxcnc_axis
from tests.apps.tune.machine import BenchMachine, written

from bristle.apps.tune import MachineStoppedError, Tuning, tune, undo
from bristle.apps.tune.journal import Journal
from bristle.apps.tune.linuxcnc.hal import Hal
from bristle.apps.tune.linuxcnc.saved import guard
from bristle.apps.tune.machines import connected
from bristle.apps.tune.steps import ORDER
from bristle.files import read_machine
from bristle.report.compared import compare

FIRST = 3000  # seeds from here on were not used to build the program
WINDOW = 0.1  # around a reversal [s]
PATIENCE = 2.5  # of the guard in HAL, with its ramp [s]
# Of a record that is compared; records that warm an axis up.
CYCLES, WARM_UP = (4, (0, 0, 0, 0, 0, 0))
STOPS = 12  # times four stops: with the feedforward and without it, twice each


def reversals(motion: Motion) -> np.ndarray:
    """Return the samples of a cycle at which the motion reverses."""
    side = np.sign(np.diff(motion.cycle, append=motion.cycle[0]))
    moving = np.flatnonzero(side)
    return moving[np.flatnonzero(side[moving] != np.roll(side[moving], 1))]


def errors(
    plant: Plant,
    motion: Motion,
    seed: int,
    feed: Callable[[np.ndarray], np.ndarray],
    gain: float,
    *,
    truth: bool = False,
) -> Any:
    """Return rms and rms around reversals of the true error over ten cycles [m]; NaN if the loop leaves its limits."""
    bench, cycles = Bench(plant, seed), 12
    bench.guard.gain = gain
    played = motion.played(cycles)
    rows, _, why = bench.play(played, feed(played), feed_is_truth=truth)
    if why or not np.all(np.isfinite(rows)):
        return np.nan, np.nan
    table = (played - rows[:, 2])[200:-200].reshape(cycles, -1)[2:]
    width = round(WINDOW / plant.sample_time)
    near = (
        np.concatenate([np.arange(at - width, at + width) for at in reversals(motion)])
        % table.shape[1]
    )
    return float(np.sqrt(np.mean(table**2))), float(np.sqrt(np.mean(table[:, near] ** 2)))


def one_axis(seed: int) -> tuple[Tuning, dict[str, float]]:
    """Tune a random axis; return the result, and errors before, after and with the true friction."""
    with tempfile.TemporaryDirectory() as folder:
        file, bench, motion = written(Path(folder), seed)
        machine = BenchMachine(bench)
        result = tune(file, Path(folder) / "out", move=True, machine=machine)
    if result.outcome != "kept":
        return result, {}
    assert machine.feedforward is not None
    feedforward, step = machine.feedforward, bench.plant.sample_time
    of = {
        "before": errors(bench.plant, motion, seed, np.zeros_like, 0.0),
        "after": errors(
            bench.plant,
            motion,
            seed,
            lambda played: feedforward.along(played, step),
            result.facts["comparison"]["gain"],
        ),
        "truth": errors(bench.plant, motion, seed, np.zeros_like, 1.0, truth=True),
    }
    table = {
        f"{side}_{what}": value
        for side, pair in of.items()
        for what, value in zip(("rms", "reversal"), pair, strict=True)
    }
    for name, pair in stops(
        bench, motion, seed, feedforward, result.facts["comparison"]["gain"], of["before"][0]
    ).items():
        table |= {f"before_{name}": pair[0], f"after_{name}": pair[1]}
    return result, table


def stops(
    bench: Bench, motion: Motion, seed: int, feedforward: Any, gain: float, error: float
) -> dict[str, np.ndarray]:
    """Return rms effort in motion, rms effort at rest and settling time, before and after, each from many stops."""
    plant, rest, last = (
        bench.plant,
        round(1.0 / bench.plant.sample_time),
        round(0.05 / bench.plant.sample_time),
    )
    axis, played = Bench(plant, seed), motion.played(2, rest)
    feed, sides = feedforward.along(played, plant.sample_time), ([], [])
    for side in STOPS * (0, 1, 1, 0):
        axis.guard.gain = side * gain
        rows, _, _ = axis.play(played, feed)
        effort, away = (
            rows[:, 1],
            np.abs(played - rows[:, 0])[-rest:] > max(0.25 * error, 2.0 * plant.resolution),
        )
        # The axis has settled at the first sample behind which the error stays in its band for 50 ms.
        runs = np.lib.stride_tricks.sliding_window_view(away, last).any(axis=1)
        settled = int(np.argmin(runs)) if not runs.all() else rest
        halves = slice(rest // 2, rest), slice(-rest // 2, None)
        noise, swing = (
            np.std(np.concatenate([detrend(signal[half]) for half in halves]))
            for signal in (effort, rows[:, 0])
        )
        sides[side].append(
            (np.std(effort[rest:-rest]), noise, max(settled, last) * plant.sample_time, swing)
        )
    table = np.array(sides)
    # Less noise than by a count of the encoder, or than a twentieth of the effort in motion, does not count.
    moves = table[:, :, 3] > 0.1 * plant.resolution
    count = (
        np.min(plant.resolution * table[:, :, 1][moves] / table[:, :, 3][moves])
        if moves.any()
        else 0.0
    )
    table[:, :, 1] = np.maximum(table[:, :, 1], max(count, 0.05 * np.mean(table[0, :, 0])))
    return dict(
        zip(
            ("effort", "noise", "settling"),
            np.exp(np.mean(np.log(table[:, :, :3]), axis=1)).T,
            strict=True,
        )
    )


def gain(count: int = 30) -> bool:
    """Tune random axes and print each; the medians must reach their goals."""
    rows = []
    for seed in range(FIRST, FIRST + count):
        result, e = one_axis(seed)
        plant = drawn(seed)[0]
        name = f"{seed} {KINDS[plant.kind]}{', two masses' if plant.load else ''}{', gravity and cogging' if plant.gravity else ''}"
        if not e:
            print(f"{name}: {result.outcome}, {result.code}: {result.reason}", flush=True)
            continue
        fall = 1.0 - e["after_reversal"] / e["before_reversal"]
        share = (e["before_rms"] - e["after_rms"]) / (e["before_rms"] - e["truth_rms"])
        ratios = {"error": e["after_rms"] / e["before_rms"]} | {
            name: e[f"after_{name}"] / e[f"before_{name}"]
            for name in ("effort", "noise", "settling")
        }
        largest = max(ratios, key=lambda name: ratios[name])
        worst = ratios[largest]
        rows.append((fall, share, worst))
        print(
            f"{name}: {result.facts['identification']['model']}, gain {result.facts['comparison']['gain']:.2f}, rms "
            f"{1e6 * e['before_rms']:.1f} to {1e6 * e['after_rms']:.1f} µm ({1e6 * e['truth_rms']:.1f} with the true friction), around "
            f"reversals −{fall:.0%}, share {share:.0%}, largest ratio {worst:.2f} ({largest})",
            flush=True,
        )
    table = np.array(rows).reshape(-1, 3)
    falls, shares = np.nanmedian(table[:, 0]), np.nanmedian(table[:, 1])
    print(
        f"kept {len(rows)} of {count}; median around reversals −{falls:.0%} (goal −70 %), median share {shares:.0%} (goal 85 %)"
    )
    print(
        f"largest ratio of error, effort, noise or settling in a kept run {np.max(table[:, 2], initial=0.0):.3f} (goal 1.05)"
    )
    return bool(falls >= 0.70 and shares >= 0.85 and np.max(table[:, 2], initial=0.0) <= 1.05)


def kills(count: int = 200) -> bool:
    """Kill runs behind a random entry of their journal; each machine must read back as before at the next start."""
    generator, restored = np.random.default_rng(20261127), 0
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder) / "base"
        file, bench, _ = written(base, 4, 6)
        tune(
            file,
            base / "out",
            move=True,
            machine=BenchMachine(bench, memory=base / "memory.json"),
            options=OPTIONS,
        )
        last = len(Journal(base / "out").entries)
        for number in range(count):
            target = Path(folder) / f"{number}"
            target.mkdir()
            make, place = begun(base, target)
            untouched = dict(make().state())
            first = len(Journal(place / "out").entries)
            entry_of_kill = int(generator.integers(first, last))
            was_killed = killed(
                entry_of_kill,
                lambda place=place, make=make: tune(
                    place / "machine.toml",
                    place / "out",
                    move=True,
                    machine=make(),
                    options=OPTIONS,
                ),
            )
            machine = make()
            tune(place / "machine.toml", place / "out", machine=machine, options=OPTIONS)
            entry = Journal(place / "out").last("restored")
            same = dict(machine.state()) == untouched and (entry is None or entry["identical"])
            restored += same
            if not was_killed or not same:
                print(f"{number}: {'not restored' if was_killed else 'not killed'}", flush=True)
    print(f"restored {restored} of {count} killed runs (goal: all)")
    return restored == count


def intervals(count: int = 300, first: int = 5000) -> bool:
    """Count the claimed 95 % intervals that contain the true change, on warming axes: with the records of both sides at all times."""
    held, total = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        for seed in (4, 5, 9):
            base = Path(folder) / f"{seed}"
            file, bench, motion = written(base, seed)
            machine = BenchMachine(bench)
            tune(file, base / "out", move=True, machine=machine, options=OPTIONS)
            assert machine.feedforward is not None
            played = motion.played(CYCLES + 2)
            feed, seeds = (
                machine.feedforward.along(played, bench.plant.sample_time),
                range(first, first + count // 3),
            )
            # The same times and states of warmth, with the feedforward in all records and in none of them.
            of: tuple[list[Any], list[Any]] = ([], [])
            for side, tables in enumerate(of):
                for own in seeds[::8]:
                    tables += _recorded(
                        bench.plant, played, feed, own + 1000, motion, len(ORDER) * (side,)
                    )
            truth = compare(*of).changes["following_error.rms"]
            changes = []
            for own in seeds:
                tables = _recorded(bench.plant, played, feed, own, motion, ORDER)
                sides = (
                    [table for table, given in zip(tables, ORDER, strict=True) if given == side]
                    for side in (0, 1)
                )
                changes.append(compare(*sides).changes["following_error.rms"])
            inside = sum(
                change.interval[0] <= truth.change <= change.interval[1] for change in changes
            )  # type: ignore[index]
            half = 50.0 * np.median([np.ptp(change.interval) for change in changes]) / truth.before  # type: ignore[arg-type]
            scatter = 196.0 * np.std([change.change for change in changes], ddof=1) / truth.before
            print(
                f"{seed}: {inside} of {len(changes)}, change {truth.change_percent:.2f} %, half-width {half:.3f} % "
                f"(1.96 standard deviations of the change: {scatter:.3f} %)",
                flush=True,
            )
            held, total = held + inside, total + len(changes)
    share = held / total
    print(
        f"{held} of {total} claimed intervals contain the true change, {share:.1%} (goal 92 to 98 %)"
    )
    return 0.92 <= share <= 0.98


def _recorded(
    plant: Plant,
    played: np.ndarray,
    feed: np.ndarray,
    seed: int,
    motion: Motion,
    order: tuple[int, ...],
) -> list[Any]:
    """Return the records of an axis that warms up, in turn with gain 0 and 1, without two cycles that run in."""
    bench = Bench(Plant(**{**vars(plant), "warm_up": 0.03, "heat": 200.0}), seed)
    inside, tables = slice(200 + 2 * motion.cycle.size, -200), []
    for gain in (*WARM_UP, *order):
        bench.guard.gain, begin = float(gain), bench.values[10]
        rows, _, _ = bench.play(played, feed)
        time = begin + np.arange(played.size) * plant.sample_time
        table = {"time": time, "position": rows[:, 0], "effort": rows[:, 1], "reference": played}
        tables.append({name: signal[inside] for name, signal in table.items()})
    return tables[len(WARM_UP) :]


def linuxcnc(count: int = 20, first: int = 101) -> bool:
    """Tune random axes in LinuxCNC's HAL; compare with the true friction of the plant, fed one cycle late through the same pins."""
    rows, kept = [], 0
    for seed in range(first, first + count):
        begin = time.monotonic()
        with (
            tempfile.TemporaryDirectory() as folder,
            linuxcnc_axis(seed, Path(folder)) as (hal, file, cycle),
        ):
            result = tune(file, Path(folder) / "out", move=True)
            minutes = (time.monotonic() - begin) / 60.0
            kind = KINDS[seed % 4] + ", two masses" * (seed % 3 == 0)
            if result.outcome != "kept":
                print(
                    f"{seed} {kind}: {result.outcome}, {result.code}: {result.reason} ({minutes:.1f} min)",
                    flush=True,
                )
                continue
            kept += 1
            machine, played = (
                connected(read_machine(file)),
                1e-3 * np.concatenate([np.zeros(500), np.tile(cycle, 8), np.zeros(500)]),
            )
            errors_of: dict[str, tuple[float, float]] = {}
            for side in ("before", "after", "truth"):
                if side == "truth":
                    feeder = next(
                        pin for pin in hal.links()["bristle-feed"] if pin != "bristle-guard.feed"
                    )
                    hal.run(
                        f"unlinkp {feeder}",
                        "unlinkp bristle-guard.feed",
                        "net truth rplant.0.friction => bristle-guard.feed",
                    )
                machine.set(
                    gain={"before": 0.0, "after": result.facts["comparison"]["gain"], "truth": 1.0}[
                        side
                    ]
                )
                try:
                    errors_of[side] = _reversal_errors(
                        machine.record(played, lambda: None).error[500:-500], cycle
                    )
                except MachineStoppedError as stopped:
                    errors_of[side] = (np.nan, np.nan)
                    print(f"{seed}: {side}: {stopped}")
            machine.set()
        (before, at_before), (after, at_after), (truth, at_truth) = (
            errors_of[side] for side in ("before", "after", "truth")
        )
        fall, share = 1.0 - at_after / at_before, (before - after) / (before - truth)
        rows.append((fall, share, after / before))
        print(
            f"{seed} {kind}: {result.facts['identification']['model']}, gain {result.facts['comparison']['gain']:.2f}, "
            f"rms {1e6 * before:.1f} "
            f"to {1e6 * after:.1f} µm ({1e6 * truth:.1f}), behind reversals −{fall:.0%} (−{1.0 - at_truth / at_before:.0%} with the true "
            f"friction), share {share:.0%}, {minutes:.1f} min",
            flush=True,
        )
    table = np.array(rows).reshape(-1, 3)
    print(
        f"kept {kept} of {count}; median behind reversals −{np.nanmedian(table[:, 0]):.0%} (goal −90 %)"
    )
    shares = table[:, 1]
    most = np.nanmean(shares >= 0.8)
    print(
        f"share of the possible reduction: median {np.nanmedian(shares):.0%} (goal 90 %), above 80 % in {most:.0%}"
    )
    return bool(
        np.nanmedian(table[:, 0]) >= 0.9
        and np.nanmedian(shares) >= 0.9
        and np.all(table[:, 2] < 1.0)
    )


def hal_kills(each: int = 1) -> bool:
    """Kill runs in LinuxCNC's HAL behind each line of the journal of a whole run.

    The guard must remove the feedforward within its patience and its ramp, and the next start must restore the machine.
    """
    fates = []
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder) / "base"
        with linuxcnc_axis(105, base) as (hal, file, _):
            machine = connected(read_machine(file))
            untouched = _as_read(machine.state())
            result = tune(file, base / "out", move=True, options=OPTIONS)
            entries = Journal(base / "out").entries
            undone = (
                undo(base / "out").outcome == "undone" and _as_read(machine.state()) == untouched
            )
            print(
                f"a whole run: {result.outcome}, {len(entries)} lines, undone to the bit: {undone}",
                flush=True,
            )
            identified = next(
                entry["n"]
                for entry in entries
                if entry["step"] == "identification" and entry["event"] == "done"
            )
            for line in range(0, len(entries), each):
                target = Path(folder) / f"{line}"
                target.mkdir()
                if line > identified:
                    begun(base, target)
                else:
                    for name in ("axis.toml", "machine.toml", "motion.csv"):
                        shutil.copy(base / name, target / name)
                step = entries[line]["step"]
                place = step, sum(entry["step"] == step for entry in entries[:line])
                was_killed = killed(
                    place,
                    lambda target=target: tune(
                        target / "machine.toml", target / "out", move=True, options=OPTIONS
                    ),
                )
                finished = Journal(
                    target / "out"
                ).is_kept  # the last line: the run is finished, and its gain stays
                gain, seconds = (1.0, 0.0) if finished else _faded(hal)
                if finished:
                    undo(target / "out")
                else:
                    tune(target / "machine.toml", target / "out", options=OPTIONS)
                same = _as_read(machine.state()) == untouched
                # Whose cycles agree after fewer or more pairs in another run.
                if was_killed or place[0] != "warm_up":
                    fates.append(was_killed and same and seconds <= PATIENCE)
                words = " ".join(
                    str(entries[line].get(key, "")) for key in ("step", "event", "what", "gain")
                )
                print(
                    f"line {line} ({words}): gain {gain:.2f} at the kill, 0 after {seconds:.1f} s, restored {same}",
                    flush=True,
                )
    print(f"gain 0 within {PATIENCE:.1f} s and restored: {sum(fates)} of {len(fates)} (goal: all)")
    return undone and all(fates)


def _faded(hal: Hal) -> tuple[float, float]:
    """Return the gain in the guard behind a kill, and the time until it is 0 [s]."""
    begin, gain, first = time.monotonic(), 0.0, None
    while guard() in hal.components():
        gain = hal.get("bristle-guard.gain-now")[0]
        first = gain if first is None else first
        if gain == 0.0 or time.monotonic() - begin > 2.0 * PATIENCE:
            break
        time.sleep(0.02)
    return first or 0.0, time.monotonic() - begin


def _as_read(state: Any) -> Any:
    return json.loads(json.dumps(dict(state)))


def _reversal_errors(error: np.ndarray, cycle: np.ndarray) -> tuple[float, float]:
    """Return rms of an error, and its mean peak within a tenth of a cycle behind a reversal, without its mean [m]."""
    table = error.reshape(-1, cycle.size)[2:] - np.mean(error)
    width = cycle.size // 10
    peaks = [
        np.max(np.abs(np.roll(table, -at, axis=1)[:, :width]), axis=1)
        for at in reversals(Motion(cycle))
    ]
    return float(np.sqrt(np.mean(table**2))), float(np.mean(peaks))


if __name__ == "__main__":
    name, *rest = sys.argv[1:]
    ended = {
        "gain": gain,
        "kills": kills,
        "intervals": intervals,
        "linuxcnc": linuxcnc,
        "hal_kills": hal_kills,
    }[name](*map(int, rest))
    print(json.dumps({name: bool(ended)}))
    sys.exit(0 if ended else 1)
