"""Many trajectories at once by EFIM: ordinary steps in parallel lanes, exceptional steps lane by lane.

Usually two or three evaluations of the friction model solve a step: the secant from the last slope stays in its bracket,
and neither the secant nor the body crosses zero. All lanes make these evaluations in parallel until each is solved;
further evaluations of a solved lane change nothing, because its velocity is constant. If a lane rests, reverses, or
leaves its bracket, the step is repeated for this lane alone, as in a serial run. Results are identical to a serial run.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from bristle.core.dispatch import friction_commit, plant_port, plant_step
from bristle.core.kernel import kernel
from bristle.core.packing import LANES, LaneConstants, Structure, lane_packer, lane_unpacker
from bristle.engine.drivers import BOUND, Efforts, Records
from bristle.engine.efim import INFINITY, Start, advance, evaluate, is_narrow, is_solved, slope_from
from bristle.engine.signature import Vector

EVALUATIONS = 8  # limit of evaluations before an unsolved lane makes a separate step
OPEN, SOLVED, ASIDE = 0.0, 1.0, 2.0


# One block: (block, memory, which is empty, first mechanism, number of them, efforts, dt, steps, records).
InLanes = Callable[[Vector, Vector, int, int, Efforts, float, int, Records], float]


class Span(NamedTuple):
    """Efforts [N or N*m] at a sample and at its end."""

    start: float
    end: float


class Carried(NamedTuple):
    """State of a lane between steps: result of the last solve, and effort of the drive [N or N*m]."""

    slope: float
    acceleration: float
    effort: float


class Port(NamedTuple):
    """The port of the plant over this step, ``v = a + b * F``."""

    a: float
    b: float


class Iterate(NamedTuple):
    """A trial velocity, the slope, the last residual, the bracket, and the status of the lane."""

    v: float
    slope: float
    v_last: float
    residual_last: float
    low: float
    high: float
    status: float


class Sums(NamedTuple):
    """Friction forces and failures since the last sample, total failures, and samples until the lane diverged."""

    force: float
    failures: float
    failures_so_far: float
    lost_at: float


class Scalar(NamedTuple):
    """One number of each lane."""

    value: float


def _structure(kind: Any) -> Structure:
    return kind, ("number",) * len(kind._fields)


SPAN, CARRIED, PORT, ITERATE, SUMS, SCALAR = map(
    _structure, (Span, Carried, Port, Iterate, Sums, Scalar)
)


class Rows:
    """First row of each part of a block; a row has one number of all lanes, and initial values come first."""

    def __init__(self, plant: int, plant_state: int, friction: int, friction_state: int) -> None:
        self.body = plant
        self.friction = self.body + plant_state
        self.state = self.friction + friction
        self.body_next = self.state + friction_state
        self.state_next = self.body_next + plant_state
        self.span = self.state_next + friction_state
        self.carried = self.span + len(Span._fields)
        self.port = self.carried + len(Carried._fields)
        self.iterate = self.port + len(Port._fields)
        self.status = self.iterate + Iterate._fields.index("status")
        self.force = self.iterate + len(Iterate._fields)
        self.sums = self.force + 1
        self.failures_so_far = self.sums + Sums._fields.index("failures_so_far")
        self.lost_at = self.sums + Sums._fields.index("lost_at")
        self.count = self.sums + len(Sums._fields)


@kernel
def first_guess(v, acceleration, h):
    """Return the first guess of the solve of a step of length `h` [s], as in `bristle.engine.mechanism`."""
    return 0.0 if v == 0.0 else v + 0.5 * h * acceleration


@kernel
def next_iterate(iterate, residual, solved):
    """Return the next `Iterate`, as in `bristle.engine.efim.solve`; marked for a separate step in other cases."""
    slope = slope_from(iterate.slope, iterate.v, residual, iterate.v_last, iterate.residual_last)
    low, high = (iterate.v, iterate.high) if residual < 0.0 else (iterate.low, iterate.v)
    target = iterate.v - residual / slope
    inside, same_side = low < target < high, iterate.v * target > 0.0
    usual = inside and same_side and not is_narrow(low, high, iterate.v)
    status = (
        iterate.status if iterate.status != OPEN else SOLVED if solved else OPEN if usual else ASIDE
    )
    goes_on = status == OPEN
    return Iterate(
        target if goes_on else iterate.v,
        slope if goes_on else iterate.slope,
        iterate.v if goes_on else iterate.v_last,
        residual if goes_on else iterate.residual_last,
        low if goes_on else iterate.low,
        high if goes_on else iterate.high,
        status,
    )


class _Parts:
    """Functions that load and store the parts of a lane, and their rows in a block."""

    def __init__(
        self, plant: Any, plant_state: Any, friction: Any, friction_state: Any, constants: Any
    ) -> None:
        self.plant, self.friction = lane_unpacker(plant), lane_unpacker(friction, constants)
        self.body, self.state = _access(plant_state), _access(friction_state)


def _access(structure: Structure) -> tuple[Callable[..., Any], Callable[..., Any]]:
    return lane_unpacker(structure), lane_packer(structure)


load_span, store_span = _access(SPAN)
load_carried, store_carried = _access(CARRIED)
load_port, store_port = _access(PORT)
load_iterate, store_iterate = _access(ITERATE)
load_sums, store_sums = _access(SUMS)
load, store = _access(SCALAR)


def _beginnings(parts: _Parts, rows: Rows) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return the functions that prepare the lanes for a sample, and for a step."""
    unpack_plant, load_plant = parts.plant, parts.body[0]
    BODY, SPANS, CARRIES, PORTS, ITERATES = (
        rows.body,
        rows.span,
        rows.carried,
        rows.port,
        rows.iterate,
    )
    TOTALS = rows.sums

    @kernel
    def begin_sample(block, efforts, k, first, used, h):
        """Prepare each lane for a sample: its efforts and its sums."""
        at = k * efforts.columns
        for j in range(LANES):
            # Lanes beyond the last trajectory repeat iterate.
            m = at + first + min(j, used - 1) if efforts.columns > 1 else at
            store_span(Span(efforts.start[m], efforts.end[m]), block, SPANS, j)
        for j in range(LANES):
            carried, sums = load_carried(block, CARRIES, j), load_sums(block, TOTALS, j)
            store_carried(
                Carried(1.0 + carried.slope * h, carried.acceleration, carried.effort),
                block,
                CARRIES,
                j,
            )
            store_sums(Sums(0.0, 0.0, sums.failures_so_far, sums.lost_at), block, TOTALS, j)

    @kernel
    def begin_step(block, h, part):
        """Prepare the step of each lane: its effort, and the start of its solve."""
        for j in range(LANES):
            q, body = unpack_plant(block, 0, j), load_plant(block, BODY, j)
            span, carried = load_span(block, SPANS, j), load_carried(block, CARRIES, j)
            commanded = span.start + (span.end - span.start) * part
            # Identical to `bristle.engine.mechanism` with a drive without lag.
            u = commanded + 0.0 * (carried.effort - commanded)
            a, b = plant_port(body, u, h, q)
            guess, slope = first_guess(body.v, carried.acceleration, h), max(carried.slope, 1.0)
            store_carried(Carried(carried.slope, carried.acceleration, u), block, CARRIES, j)
            store_port(Port(a, b), block, PORTS, j)
            status = ASIDE if guess == 0.0 else OPEN
            store_iterate(
                Iterate(guess, slope, 0.0, 0.0, -INFINITY, INFINITY, status), block, ITERATES, j
            )

    return begin_sample, begin_step


def _solving(parts: _Parts, rows: Rows) -> tuple[Callable[..., Any], ...]:
    """Return the functions that evaluate the lanes, move them, and make exceptional steps one by one."""
    unpack_plant, unpack_friction = parts.plant, parts.friction
    (load_plant, store_plant), (load_friction, store_friction) = parts.body, parts.state
    BODY, BODY_NEXT, STATE, STATE_NEXT, P = (
        rows.body,
        rows.body_next,
        rows.state,
        rows.state_next,
        rows.friction,
    )
    CARRIES, PORTS, ITERATES, STATUS, FORCE = (
        rows.carried,
        rows.port,
        rows.iterate,
        rows.status,
        rows.force,
    )
    TOTALS = rows.sums

    @kernel
    def evaluate_lanes(block, memory, h):
        """Evaluate each lane at its velocity, store the result, and return the number of unsolved lanes."""
        count = 0
        for j in range(LANES):
            s, p, iterate = (
                load_friction(block, STATE, j),
                unpack_friction(block, P, j),
                load_iterate(block, ITERATES, j),
            )
            u, port = load_carried(block, CARRIES, j).effort, load_port(block, PORTS, j)
            x = load_plant(block, BODY, j).x
            force, move = evaluate(s, memory, iterate.v, x, u - (iterate.v - port.a) / port.b, h, p)
            residual = iterate.v - port.a - port.b * force
            store_friction(friction_commit(s, memory, move, p), block, STATE_NEXT, j)
            store(Scalar(force), block, FORCE, j)
            following = next_iterate(
                iterate, residual, is_solved(residual, force, port.a, port.b, 0.0)
            )
            store_iterate(following, block, ITERATES, j)
            count += 1 if following.status == OPEN else 0
        return count

    @kernel
    def move_lanes(block, h):
        """Move each lane by its force, and return the number of exceptional lanes: reversed, at rest, or unsolved."""
        count = 0
        for j in range(LANES):
            q, body = unpack_plant(block, 0, j), load_plant(block, BODY, j)
            u, force = load_carried(block, CARRIES, j).effort, load(block, FORCE, j).value
            _, body_next = plant_step(body, u, force, h, q)
            store_plant(body_next, block, BODY_NEXT, j)
            status = load(block, STATUS, j).value
            status = SOLVED if (status == SOLVED) & (not body.v * body_next.v < 0.0) else ASIDE
            store(Scalar(status), block, STATUS, j)
            count += 1 if status == ASIDE else 0
        return count

    @kernel
    def step_aside(block, memory, h):
        """Make the exceptional steps one by one."""
        for j in range(LANES):
            sums = load_sums(block, TOTALS, j)
            if load(block, STATUS, j).value == SOLVED or sums.lost_at > 0.0:
                continue
            body, carried = load_plant(block, BODY, j), load_carried(block, CARRIES, j)
            advanced = advance(
                body,
                load_friction(block, STATE, j),
                memory,
                carried.effort,
                h,
                unpack_plant(block, 0, j),
                unpack_friction(block, P, j),
                Start(first_guess(body.v, carried.acceleration, h), carried.slope, 0.0),
            )
            store_plant(advanced.plant_state, block, BODY_NEXT, j)
            store_friction(advanced.friction_state, block, STATE_NEXT, j)
            store(Scalar(advanced.force), block, FORCE, j)
            ended = Iterate(advanced.v_mean, advanced.slope, 0.0, 0.0, 0.0, 0.0, SOLVED)
            store_iterate(ended, block, ITERATES, j)
            failures = sums.failures + advanced.failures
            store_sums(
                Sums(sums.force, failures, sums.failures_so_far, sums.lost_at), block, TOTALS, j
            )

    return evaluate_lanes, move_lanes, step_aside


def _endings(parts: _Parts, rows: Rows) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return the functions that end a step, and that record a sample."""
    (load_plant, store_plant), (load_friction, store_friction) = parts.body, parts.state
    BODY, BODY_NEXT, STATE, STATE_NEXT = rows.body, rows.body_next, rows.state, rows.state_next
    CARRIES, ITERATES, FORCE, TOTALS = rows.carried, rows.iterate, rows.force, rows.sums

    @kernel
    def end_step(block, h):
        """Accept the result of the step of each lane."""
        for j in range(LANES):
            body, iterate = load_plant(block, BODY_NEXT, j), load_iterate(block, ITERATES, j)
            carried, sums = load_carried(block, CARRIES, j), load_sums(block, TOTALS, j)
            store_plant(body, block, BODY, j)
            store_friction(load_friction(block, STATE_NEXT, j), block, STATE, j)
            store_carried(
                Carried(iterate.slope, 2.0 * (body.v - iterate.v) / h, carried.effort),
                block,
                CARRIES,
                j,
            )
            total = sums.force + load(block, FORCE, j).value
            store_sums(
                Sums(total, sums.failures, sums.failures_so_far, sums.lost_at), block, TOTALS, j
            )

    @kernel
    def end_sample(block, k, h):
        """Count failures, and mark diverged lanes, whose later results are invalid."""
        for j in range(LANES):
            body, carried = load_plant(block, BODY, j), load_carried(block, CARRIES, j)
            sums = load_sums(block, TOTALS, j)
            failures = sums.failures_so_far + (sums.failures if sums.lost_at == 0.0 else 0.0)
            is_lost = (sums.lost_at == 0.0) & (not abs(body.x) + abs(body.v) < BOUND)
            store_sums(
                Sums(sums.force, sums.failures, failures, k + 1.0 if is_lost else sums.lost_at),
                block,
                TOTALS,
                j,
            )
            store_carried(
                Carried((carried.slope - 1.0) / h, carried.acceleration, carried.effort),
                block,
                CARRIES,
                j,
            )

    return end_step, end_sample


def make_lanes(
    plant: Structure,
    plant_state: Structure,
    friction: Structure,
    friction_state: Structure,
    rows: Rows,
    constants: LaneConstants,
) -> Callable[..., Any]:
    """Return the entry that drives one block by EFIM: the `used` mechanisms from `first` on.

    The friction model must not have a memory, because commits are repeated. `constants` describes parameters that are
    equal in all lanes.
    """
    parts = _Parts(plant, plant_state, friction, friction_state, constants)
    begin_sample, begin_step = _beginnings(parts, rows)
    evaluate_lanes, move_lanes, step_aside = _solving(parts, rows)
    end_step, end_sample = _endings(parts, rows)
    load_plant = parts.body[0]
    BODY, TOTALS = rows.body, rows.sums

    def lanes(block, memory, first, used, efforts, dt, steps, records):
        h = dt / steps
        x, v, force, count = records.x, records.v, records.force, records.mechanisms
        for k in range(x.size // count):
            at = k * count + first
            for j in range(used):
                body = load_plant(block, BODY, j)
                x[at + j], v[at + j] = body.x, body.v
            begin_sample(block, efforts, k, first, used, h)
            for i in range(steps):
                begin_step(block, h, (i + 0.5) / steps)
                for _ in range(EVALUATIONS):
                    if evaluate_lanes(block, memory, h) == 0:
                        break
                if move_lanes(block, h) > 0:
                    step_aside(block, memory, h)
                end_step(block, h)
            for j in range(used):
                force[at + j] = load_sums(block, TOTALS, j).force / steps
            end_sample(block, k, h)
        return 0.0

    return lanes
