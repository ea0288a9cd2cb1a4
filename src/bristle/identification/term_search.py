"""Search for the terms of a log: delay, ripples, and the terms that lower the error of held-out folds."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bristle.core.least_squares import unbounded
from bristle.identification.dictionary import (
    Grid,
    Group,
    Level,
    Motion,
    filter_group,
    friction_groups,
    grid_of,
    level_groups,
    line_of_ramps,
    place_groups,
    plant_groups,
    ripple_group,
    scale_group,
)
from bristle.identification.explanation import Evidence
from bristle.identification.gram import FOLDS, ROUNDING, Equations, Penalties, are_alike, rms

SLOW = 0.05  # of the top speed: rows below it have no weight in the delay and the inertia
RISE = 0.1  # of the top speed, over which the weight of a row rises to 1
LEAST_WEIGHT = 1e-3
COARSE = np.arange(-13, 14) * 0.05  # periods of the cut-off: first delays of the search
FINE = np.arange(-3, 4) * 0.02  # periods of the cut-off: further delays around the best one
PASSES = 2  # over the changes of the level, which are relative to the friction of the last fit

NO_MOTION = 2e-3  # of the top speed
# Periods of the cut-off from a row to the nearest reversal.
BANDS = np.array([0.5, 1.0, 2.0, 4.0, 8.0, 16.0])
QUIET = 0.25  # of the median power of the residual: its power in a band, at least

CELLS = 16_384  # of the stroke, for the periodogram over the position
PADDING = 4  # lengths of the padded periodogram
SLOWEST_WAVE = 2.5  # waves in the stroke
FASTEST_WAVE = 2000.0  # waves in the stroke
WAVES_A_SEARCH = 4
MOST_WAVES = 6
LEAST_WAVE = 0.004  # of the power of the residual
FALSE_WAVE = 0.01  # chance that white noise shows a wave
REFINEMENTS = (0.3, 0.05)  # waves in the stroke: moves of a frequency in two searches
NEAR_WAVES = 0.7  # waves in the stroke: nearer frequencies are the same

WARM_UP = "warmup"
LEAST_CYCLE = 0.05  # of the mean: work of friction in a half-cycle that shows a level
CHANCE = 0.01  # that scattering levels look like warm-up
SMOOTH_LEVELS = ("level", "load", "warmup")
LEAST_UNIQUE = 0.003  # of a column: the part that friction and inertia do not explain
LEAST_GAIN = 0.012  # of the rms of friction, held out: the smallest term
LEAST_CABLE = 0.006
LEAST_Z = 2.5  # standard errors of the mean logarithm of the held-out errors


# ---------------------------------------------------------------- weights of rows, ripples
def time_to_reversal(motion: Motion) -> np.ndarray:
    """Return the time from each row to the nearest reversal or rest, in periods of the cut-off, shape (row,)."""
    speed = np.abs(motion.v)
    side = np.sign(np.where(speed > NO_MOTION * speed.max(), motion.v, 0.0))
    turns = np.flatnonzero(np.diff(side) != 0.0)
    ends = np.concatenate([[-np.inf], turns, [np.inf]])
    after = np.searchsorted(turns, motion.places) + 1
    gap = np.minimum(ends[after] - motion.places, motion.places - ends[after - 1])
    return gap * motion.dt * motion.cutoff


def reversal_weights(motion: Motion, residual: np.ndarray) -> np.ndarray:
    """Return the weight of each row, by the residual in bands of the time to the nearest reversal."""
    band = np.searchsorted(BANDS, time_to_reversal(motion))
    power = np.full(BANDS.size + 1, np.nan)
    for number in np.unique(band):
        power[number] = np.mean(residual[band == number] ** 2)
    power = np.maximum(power, QUIET * np.nanmedian(power))
    weight = 1.0 / power[band]
    return weight / weight.mean()


def waves_in(motion: Motion, grid: Grid, residual: np.ndarray) -> list[float]:
    """Return the frequencies of waves in the residual over the position [1/m or 1/rad], the strongest first."""
    x = motion.x[motion.places]
    left = residual.copy()
    cell = np.minimum(((x - grid.low) / grid.stroke * CELLS).astype(int), CELLS - 1)
    frequencies = np.fft.rfftfreq(PADDING * CELLS, grid.stroke / CELLS)
    # Shorter waves are the noise of the position.
    fastest = min(FASTEST_WAVE / grid.stroke, 0.25 / max(grid.narrow[0], 1e-300))
    able = (frequencies > SLOWEST_WAVE / grid.stroke) & (frequencies < fastest)
    trials = max(np.count_nonzero(able) / PADDING, 2.0)
    least = max(LEAST_WAVE, 2.0 * math.log(trials / FALSE_WAVE) / x.size)
    waves = list[float]()
    total = float(left @ left)
    for _ in range(WAVES_A_SEARCH):
        sums = np.bincount(cell, left, CELLS)
        spectrum = np.abs(np.fft.rfft(sums, PADDING * CELLS)) ** 2
        best = float(frequencies[able][np.argmax(spectrum[able])])
        shifts = np.linspace(-0.3, 0.3, 13) / grid.stroke
        powers = np.array([wave_at(best + shift, x, left)[0] for shift in shifts.tolist()])
        frequency = best + peak_of(shifts, powers)
        power, wave = wave_at(frequency, x, left)
        if power < least * total:
            break
        waves.append(frequency)
        left = left - wave
    return waves


def wave_at(frequency: float, x: np.ndarray, residual: np.ndarray) -> tuple[float, np.ndarray]:
    """Return power and values of the wave of a frequency in a residual."""
    phase = 2.0 * np.pi * frequency * x
    W = np.stack([np.cos(phase), np.sin(phase)], axis=1)
    right = W.T @ residual
    weights = np.linalg.solve(W.T @ W, right)
    return float(weights @ right), W @ weights


def wave_power(
    frequency: float, x: np.ndarray, side: np.ndarray, weight: np.ndarray, residual: np.ndarray
) -> float:
    """Return the weighted power of a wave in a residual, equal in both directions and opposite."""
    phase = 2.0 * np.pi * frequency * x
    W = np.stack([np.cos(phase), np.sin(phase)], axis=1)
    W = np.hstack([W, W * side[:, None]])
    weighted = W * weight[:, None]
    right = weighted.T @ residual
    # In one direction both are the same.
    gram = weighted.T @ W + ROUNDING * weight.sum() * np.eye(4)
    return float(np.linalg.solve(gram, right) @ right)


def peak_of(at: np.ndarray, values: np.ndarray) -> float:
    """Return the place of the largest value on an even grid: vertex of a parabola through three values."""
    best = int(np.clip(np.argmax(values), 1, at.size - 2))
    before, here, after = values[best - 1 : best + 2].tolist()
    bend = before - 2.0 * here + after
    if bend >= 0.0:
        return float(at[best])
    vertex = min(max(0.5 * (before - after) / bend, -1.0), 1.0)
    return float(at[best] + (at[1] - at[0]) * vertex)


# ---------------------------------------------------------------- all columns at once
class Search:
    """The fit of all columns: delay, ripples, and the friction to which changes of the level are relative."""

    def __init__(self, motion: Motion, delay: float | None = None) -> None:
        self.motion = motion
        self.known_delay = delay
        self.grid = grid_of(motion)
        self.plant = plant_groups(motion)
        self.places = place_groups(motion, self.grid)
        self.base = [*self.plant, *friction_groups(motion, self.grid), self.places["curve"]]
        speed = np.abs(motion.v[motion.places]) / self.grid.V
        self.fast = np.clip((speed - SLOW) / RISE, LEAST_WEIGHT, 1.0)
        self.weight = np.ones(motion.places.size)
        self.frequencies = list[float]()
        self.scales = dict[float, Group]()  # errors of the encoder with these frequencies
        self.every = self.base
        self.equations = Equations(self.base, motion.row(motion.u), self.weight)
        self.delay = 0.0
        self.is_at_edge = False
        self.friction = np.zeros(motion.x.size)
        self.dry = self.friction
        self.fitted = self.equations.fit(self.base)

    def fit(self) -> None:
        """Find the delay, the ripples, and the fit of all columns."""
        equations = self.equations
        self.find_delay(self.base)
        self.fitted = equations.fit(self.base, None, self.fitted.support)
        residual = self.residual
        self.weight = reversal_weights(self.motion, residual)
        self.add_waves(residual)
        for turn in range(PASSES):
            self.refit()
            if turn < PASSES - 1:
                residual = self.residual
                self.refine_waves()
                self.find_delay(self.every)
                self.add_waves(residual)

    @property
    def residual(self) -> np.ndarray:
        """Effort of the rows that the fit leaves unexplained [N or N*m], shape (row,)."""
        equations = self.equations
        return equations.y - equations.unit * (equations.X @ self.fitted.weights)

    def force(self, *roles: str) -> np.ndarray:
        """Return the force of the groups of some roles along the motion, shape (sample,) [N or N*m]."""
        total = np.zeros(self.motion.x.size)
        for group in self.every:
            if group.role in roles:
                total += group.force(self.equations.physical(group, self.fitted.weights))
        return total

    def viscous_force(self) -> np.ndarray:
        """Return viscous friction along the motion, shape (sample,) [N or N*m]."""
        weights = {
            group.name: self.equations.physical(group, self.fitted.weights) for group in self.base
        }
        v = self.motion.v
        return weights["viscous"][0] * v + line_of_ramps(v, weights["ramps"], self.grid.V)

    def refine_waves(self) -> None:
        """Move the frequency of each wave to the largest power in the residual with its own force."""
        motion = self.motion
        x = motion.x[motion.places]
        side = np.sign(motion.v[motion.places])
        residual = self.residual
        refined = list[float]()
        for frequency in self.frequencies:
            own = [group for group in self.every if group.frequency == frequency]
            at = self.equations.columns_of(own)
            force = self.equations.X[:, at] @ self.fitted.weights[at]
            left = residual + self.equations.unit * force
            for width in REFINEMENTS:
                shifts = np.linspace(-width, width, 7) / self.grid.stroke
                powers = [
                    wave_power(frequency + shift, x, side, self.weight, left)
                    for shift in shifts.tolist()
                ]
                frequency += peak_of(shifts, np.array(powers))
            refined.append(frequency)
        self.frequencies.clear()
        self.add_frequencies(refined)

    def refit(self) -> None:
        """Fit all columns, with changes of the level relative to the friction of the last fit."""
        self.friction = self.force("friction")
        self.dry = self.friction - self.viscous_force()
        place = self.force("place", "offset")
        inertia = self.force("inertia")
        effort = inertia + self.friction + place
        y = self.equations.y
        waves = [ripple_group(self.motion, frequency) for frequency in self.frequencies]
        transmitted = self.motion.smooth(inertia) + place
        signals = Level(self.friction, self.dry, transmitted)
        levels = level_groups(self.motion, self.grid, signals, self.frequencies)
        self.every = [*self.base, *waves, *levels, filter_group(self.motion, effort)]
        shapes = [group for name, group in self.places.items() if name != "curve"]
        names = {group.name for group in self.base}
        start = {name: value for name, value in self.fitted.penalties.items() if name in names}
        self.scales = {
            frequency: scale_group(self.motion, frequency) for frequency in self.frequencies
        }
        columns = [*self.every, *shapes, *self.scales.values()]
        self.equations = Equations(columns, y, self.weight)
        self.fitted = self.equations.fit(self.every, start)
        self.weight = reversal_weights(self.motion, self.residual)
        self.equations.weigh(self.weight)
        penalties = self.fitted.penalties
        self.fitted = self.equations.fit(self.every, penalties, self.fitted.support, rounds=1)

    def add_waves(self, residual: np.ndarray) -> None:
        """Add the waves of a residual over the position, equal in both directions or opposite, that differ from the known waves."""
        side = np.sign(self.motion.v[self.motion.places])
        frequencies = waves_in(self.motion, self.grid, residual)
        frequencies += waves_in(self.motion, self.grid, residual * side)
        self.add_frequencies(frequencies)

    def add_frequencies(self, frequencies: Sequence[float]) -> None:
        """Add the frequencies that differ from the known ones [1/m or 1/rad]."""
        for frequency in frequencies:
            distances = [abs(frequency - known) * self.grid.stroke for known in self.frequencies]
            if min(distances, default=math.inf) > NEAR_WAVES and len(distances) < MOST_WAVES:
                self.frequencies.append(frequency)

    def find_delay(self, chosen: Sequence[Group]) -> None:
        """Find the delay from the rows at speed: near reversals, memory and delay are alike."""
        self.equations.weigh(self.fast)
        if self.known_delay is None:
            self.search_delay(chosen)
        else:
            self.delay = self.known_delay
        self.equations.y = self.motion.row(self.motion.u, self.delay)
        self.equations.weigh(self.weight)

    def search_delay(self, chosen: Sequence[Group]) -> None:
        """Search the delay over the periods of the cut-off."""
        period = 1.0 / self.motion.cutoff
        self.delay = self.best_delay(chosen, COARSE * period)
        for _ in range(2):
            self.delay = self.best_delay(chosen, self.delay + FINE * period)
        ends = COARSE[[1, -2]] * period
        self.is_at_edge = not ends[0] < self.delay < ends[1]

    def best_delay(self, chosen: Sequence[Group], delays: np.ndarray) -> float:
        """Return the delay with the least penalised error: vertex of a parabola through three delays [s]."""
        equations = self.equations
        efforts = [self.motion.row(self.motion.u, delay) for delay in delays]
        Y = np.stack(efforts, axis=1) / equations.unit
        rights = equations.X.T @ (Y * equations.weight[:, None])
        powers = equations.weight @ Y**2
        support = self.fitted.support
        errors = np.empty(delays.size)
        for number, right in enumerate(rights.T):
            weights, support = equations.solve(chosen, self.fitted.penalties, support, right)
            errors[number] = powers[number] - weights @ right
        return peak_of(delays, -errors)

    def similar_delays(
        self, chosen: Sequence[Group], penalties: Penalties, support: np.ndarray
    ) -> list[tuple[float, float]]:
        """Return the delays that the folds do not tell from the best one [s], each with its inertia."""
        equations = self.equations
        y = equations.y
        similar = list[tuple[float, float]]()
        best = np.ones(FOLDS)
        further = (COARSE / self.motion.cutoff).tolist()
        if self.known_delay is not None:
            further = []
        for delay in [self.delay, *further]:
            equations.retarget(self.motion.row(self.motion.u, delay))
            weights, active = equations.solve(chosen, penalties, support)
            errors = equations.errors_of(weights, np.flatnonzero(active))
            if not similar:
                best = errors
            if are_alike(errors, best):
                mass = float(equations.physical(self.plant[0], weights)[0])
                similar.append((delay, mass))
        equations.retarget(y)
        return similar


def explains(columns: np.ndarray, values: np.ndarray) -> bool:
    """Whether columns and a constant explain values by more than chance: an F-test."""
    from scipy.special import fdtrc  # only when needed

    count, width = columns.shape
    free = count - width - 1
    if free < 1:
        return False
    centred = values - values.mean()
    design = np.column_stack([np.ones(count), columns])
    left = centred - design @ unbounded(design, centred)
    unexplained = max(float(left @ left), np.finfo(float).tiny)
    ratio = (float(centred @ centred) / unexplained - 1.0) * free / width
    return float(fdtrc(width, free, max(ratio, 0.0))) < CHANCE


# ---------------------------------------------------------------- choice of terms
@dataclass
class Choice:
    """The terms that a log shows, and the fit with them."""

    search: Search
    groups: list[Group]
    shape: str  # of the force over the position, empty without
    evidence: dict[str, Evidence]
    rejected: dict[str, Evidence]
    support: np.ndarray


def chosen_terms(search: Search) -> Choice:
    """Return the shape of the force over the position, and the other terms by backward elimination."""
    selection = Selection(search)
    always = [group for group in search.every if group.role != "place" and not group.is_judged]
    selection.leave_out_alike(always)
    optional = [group for group in search.every if group.is_judged]
    optional = [group for group in optional if group.name not in selection.alike]
    cable = [group for group in optional if group.name == "cable"]
    terms = [group for group in optional if group.name != "cable"]
    shape = ""
    evidence = dict[str, Evidence]()
    for turn in range(2):
        # Long thresholds imitate a spring, so the shape is first chosen without them.
        shape, of_shape = selection.shape_beside(always + terms)
        if turn == 0:
            terms = terms + cable
        if shape == "curve":
            # Beside a free curve, the load would be a free level.
            alike = ("level", "load")
            terms = [group for group in terms if group.name not in alike]
            terms += [group for group in optional if group.name == "level"]
        fixed = always + [group for name, group in search.places.items() if name == shape]
        terms, of_terms = selection.eliminated(fixed, terms)
        evidence = of_shape | of_terms
    fixed = always + [group for name, group in search.places.items() if name == shape]
    terms, evidence = selection.without_scale_errors(fixed, terms, evidence)
    rejected = {name: entry for name, entry in selection.rejected.items() if name not in evidence}
    return Choice(search, fixed + terms, shape, evidence, rejected, selection.support)


class Selection:
    """Errors of held-out folds with and without terms."""

    def __init__(self, search: Search) -> None:
        self.search = search
        self.equations = search.equations
        self.penalties = dict(search.fitted.penalties)
        self.support = search.fitted.support
        # Without friction, relative to the effort.
        self.level = rms(search.motion.row(search.force("friction"))) or search.equations.unit
        self.rejected = dict[str, Evidence]()
        self.alike = set[str]()
        self.has_filter = True

    def leave_out_alike(self, always: Sequence[Group]) -> None:
        """Leave out the terms that this motion does not tell from friction and inertia, as in repetitions of one sine."""
        places = self.search.places
        groups = [group for group in self.search.every if group.name in SMOOTH_LEVELS]
        for group in [*groups, places["spring"]]:
            least, _ = self.equations.unique_shares(group, always)
            if least < LEAST_UNIQUE:
                self.alike.add(group.name)
        if "spring" in self.alike:
            self.alike |= {"cubic", "curve"}
        if "gravity" in places:
            # Over a small angle, its cosine is a constant.
            _, largest = self.equations.unique_shares(places["gravity"], always)
            if largest < LEAST_UNIQUE:
                self.alike.add("gravity")

    def errors(self, chosen: Sequence[Group]) -> np.ndarray:
        """Return the held-out errors of a choice of groups."""
        errors, _ = self.equations.held_out(chosen, self.penalties, self.support)
        return errors

    def evidence(self, without: np.ndarray, present: np.ndarray) -> Evidence:
        """Return the rise of the held-out error without a term, and its score over the folds."""
        # The best fold is left out of the gain; the mean of logarithms does not hang on few folds.
        rises = np.sort(without - present)[:-1]
        ratios = np.log(without / present)
        power = max(float(rises.mean()) * without.size, 0.0) / self.equations.count
        error = float(ratios.std(ddof=1)) / math.sqrt(ratios.size)
        gain = self.equations.unit * math.sqrt(power) / self.level
        return Evidence(gain, float(ratios.mean()) / max(error, np.finfo(float).tiny))

    def is_needed(self, evidence: Evidence, name: str = "") -> bool:
        """Whether a term lowers the held-out error by enough."""
        least = LEAST_GAIN
        # Beside unequal filters, what they leave looks like a small cable.
        if name == "cable" and not self.has_filter:
            least = LEAST_CABLE
        return evidence.gain > least and evidence.z > LEAST_Z

    def shape_beside(self, chosen: Sequence[Group]) -> tuple[str, dict[str, Evidence]]:
        """Return the simplest force over the position that no other shape beats, with its evidence."""
        errors = {"": self.errors(chosen)}
        for name, group in self.search.places.items():
            if name in self.alike:
                continue
            errors[name] = self.errors([*chosen, group])
        best = min(errors.values(), key=np.sum)
        shape = ""
        for name, of_shape in errors.items():
            shape = name
            if not self.is_needed(self.evidence(of_shape, best)):
                break
        if not shape:
            return shape, {}
        return shape, {shape: self.evidence(errors[""], errors[shape])}

    def eliminated(
        self, fixed: Sequence[Group], terms: Sequence[Group]
    ) -> tuple[list[Group], dict[str, Evidence]]:
        """Remove the weakest term until the log shows all terms; return these and their evidence."""
        remaining = list(terms)
        while True:
            chosen = [*fixed, *remaining]
            self.has_filter = any(group.name == "filter" for group in remaining)
            present, self.support = self.equations.held_out(chosen, self.penalties, self.support)
            evidence = dict[str, Evidence]()
            for group in remaining:
                without = self.errors([entry for entry in chosen if entry is not group])
                evidence[group.name] = self.evidence(without, present)
            weakest = self.weakest(evidence)
            if weakest is None and self.is_scatter(chosen):
                weakest = WARM_UP
            if weakest is None:
                return remaining, evidence
            self.rejected[weakest] = evidence[weakest]
            remaining = [group for group in remaining if group.name != weakest]

    def is_scatter(self, chosen: Sequence[Group]) -> bool:
        """Whether warm-up is not told from levels that scatter between half-cycles: an F-test of the level of each."""
        group = next((group for group in chosen if group.name == WARM_UP), None)
        if group is None:
            return False
        equations = self.equations
        motion = self.search.motion
        weights, _ = equations.solve(chosen, self.penalties, self.support)
        residual = equations.y - equations.unit * (equations.X @ weights)
        force = residual + group.columns @ equations.physical(group, weights)
        friction = motion.row(self.search.friction)
        side = np.sign(motion.v[motion.places])
        _, cycle = np.unique(np.cumsum(np.diff(side, prepend=side[0]) != 0.0), return_inverse=True)
        power = np.bincount(cycle, friction**2)
        large = power > LEAST_CYCLE * power.mean()

        def level(signal: np.ndarray) -> np.ndarray:
            return np.bincount(cycle, friction * signal)[large] / power[large]

        over_time = np.stack([level(column) for column in group.columns.T], axis=1)
        return not explains(over_time, level(force))

    def without_scale_errors(
        self, fixed: Sequence[Group], terms: Sequence[Group], evidence: Mapping[str, Evidence]
    ) -> tuple[list[Group], dict[str, Evidence]]:
        """Replace each ripple by an error of the encoder of this wavelength, if that explains more."""
        remaining = list(terms)
        of_terms = dict(evidence)
        for group in terms:
            if group.role != "place" or not group.frequency:
                continue
            scale = self.search.scales[group.frequency]
            further = [entry for entry in remaining if entry is not group]
            as_force = self.errors([*fixed, *remaining]).sum()
            if self.errors([*fixed, *further, scale]).sum() < as_force:
                remaining = [*further, scale]
                del of_terms[group.name]
        return remaining, of_terms

    def weakest(self, evidence: Mapping[str, Evidence]) -> str | None:
        """Return the term that the log shows least; None if it shows all of them."""
        weak = {name: entry for name, entry in evidence.items() if not self.is_needed(entry, name)}
        if weak:
            return min(weak, key=lambda name: weak[name].gain * max(weak[name].z, 0.0))
        return None
