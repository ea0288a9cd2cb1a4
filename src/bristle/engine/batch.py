"""Many mechanisms at once: parameter studies, Monte Carlo, identification by search."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core import Abreast, InputError, Model, Status, core_count
from bristle.core.edge import FLAG, Amount, among, array, guarded, many, model, optional, whole
from bristle.core.packing import LANES, flattener, is_scalar, lane_constants, pack, structure_of
from bristle.engine.checks import FRICTION, STEPS
from bristle.engine.compilation import compiled, driver, is_interpreted
from bristle.engine.drivers import Efforts, Mechanisms, Records, open_loops
from bristle.engine.entry_points import FAILED_SO_FAR, OUT_SIZE, MechanismVectors
from bristle.engine.instance import Instance
from bristle.engine.lanes import InLanes, Rows, make_lanes
from bristle.engine.loop import HOLDS, SAMPLE_TIME, held, substeps_entry
from bristle.engine.screwed import refuse_screw

WORTH_LANES = 10_000_000  # number of steps from which parallel lanes save time, although their compilation takes seconds


@dataclass(frozen=True)
class BatchTrace:
    """Result of a batch, in SI units of the axis; arrays of shape (trajectory, sample).

    ``position`` and ``velocity`` are instantaneous values at the sample; ``friction`` is the mean friction force until
    the next sample. ``status`` has one entry per trajectory; a diverged trajectory is NaN from the first failure.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    friction: np.ndarray
    status: tuple[Status, ...]


@guarded(
    plant=many(model("plant"), least=1, single=True),
    friction=many(FRICTION, least=1, single=True),
    effort=array(ndim=2, least=1, single=True),
    dt=SAMPLE_TIME,
    steps=STEPS,
    hold=among(*HOLDS),
    x=array(single=True),
    v=array(single=True),
    threads=optional(whole(1, 1024)),
    in_lanes=optional(FLAG),
)
def run_batch(
    plant: Model | Sequence[Model],
    friction: Model | Sequence[Model],
    effort: Any,
    dt: Amount,
    *,
    steps: int = 1,
    hold: str = "zero",
    x: Any = 0.0,
    v: Any = 0.0,
    threads: int | None = None,
    in_lanes: bool | None = None,
) -> BatchTrace:
    """Drive many mechanisms by recorded efforts, with results identical to `run_open_loop`.

    Parameters
    ----------
    plant, friction : Model or sequence of Model
        The mechanisms: a model for all trajectories, or one model per trajectory, of the same component.
    effort : array_like, shape (sample,) or (trajectory, sample)
        Effort [N or N*m] at each sample.
    dt : float
        Time between samples [s].
    steps : int
        Integration steps between two samples.
    hold : {"zero", "linear"}
        Effort between samples: constant, or linear to the next sample.
    x, v : array_like, shape () or (trajectory,)
        Position [m or rad] and velocity [m/s or rad/s] at the first sample.
    threads : int, optional
        Processor cores to use; all by default.
    in_lanes : bool, optional
        Whether to run in lanes, with several trajectories in one instruction. This needs 32 trajectories or more and a
        friction model without memory. Default: from ten million steps on. Results are the same. Lanes are compiled once
        for each kind of mechanism, and run LuGre four times as fast.

    Returns
    -------
    BatchTrace
        Position, velocity and friction of each trajectory at each sample.

    Raises
    ------
    InputError
        If the numbers of models, efforts and starts disagree, or the models have different components.
    """
    batch, cores = _Batch(plant, friction, effort, x, v), threads or core_count()
    if in_lanes is None:
        in_lanes = batch.count * len(batch.effort) * steps >= WORTH_LANES
    # A repeated trial needs a model without memory, and lanes pay off only when they are full.
    if in_lanes and batch.count >= LANES and not batch.memory.size:
        width, work = LANES, batch.in_lanes(dt, steps, hold)
    else:
        # Without lanes, a block is a share of the work, so that no core waits.
        width = max(min(LANES, -(-batch.count // cores)), 1)
        work = batch.one_by_one(dt, steps, hold, width)
    firsts = range(0, batch.count, width)
    if cores == 1 or len(firsts) == 1 or is_interpreted():
        for first in firsts:
            work(first)
    else:
        with Abreast(cores) as pool:
            list(pool.map(work, firsts))
    return batch.trace(dt)


class _Batch:
    """The mechanisms of a batch as consecutive vectors, and their records."""

    def __init__(self, plant: Any, friction: Any, effort: Any, x: Any, v: Any) -> None:
        efforts, plants, frictions = np.atleast_2d(effort), plant, friction
        odd = next((model for model in (*plants, *frictions) if model.kind != plants[0].kind), None)
        if odd is not None:
            raise InputError(
                "is of another kind of axis",
                path="friction",
                value=f"{odd.name}, {odd.kind}",
                allowed=plants[0].kind,
            )
        refuse_screw(plants[0], "run_batch")
        numbers = {
            "plants": len(plants),
            "friction models": len(frictions),
            "efforts": len(efforts),
            "positions": np.size(x),
            "velocities": np.size(v),
        }
        sizes = set(numbers.values()) - {1}
        if len(sizes) > 1:
            listed = ", ".join(f"{number} {name}" for name, number in numbers.items())
            raise InputError(
                f"cannot make one batch of {listed}",
                path="run_batch",
                mend="Give one model of each, or one for each trajectory",
            )
        self.count = sizes.pop() if sizes else 1
        self.plant, self.plants = _parameters(plants, self.count, "plant")
        self.friction, self.frictions = _parameters(frictions, self.count, "friction")
        self.body = np.tile(self.plant.state, (self.count, 1))
        self.body[:, 0], self.body[:, 1] = x, v
        self.state = np.tile(self.friction.state, (self.count, 1))
        self.memory = np.tile(
            self.friction.component.new_memory(self.friction.model.parameters), (self.count, 1)
        )
        # The trajectories of one sample are contiguous, because a block reads them together.
        self.effort = np.ascontiguousarray(efforts.T)
        self.position, self.velocity, self.force = (np.empty((self.count, 0)) for _ in range(3))
        self.out = np.zeros((self.count, OUT_SIZE))

    def one_by_one(self, dt: float, steps: int, hold: str, width: int) -> Callable[[int], Any]:
        """Return the function that runs one block of `width` trajectories one after another."""
        vectors = (self.plants, self.body, self.frictions, self.state, self.memory, self.out)
        mechanisms = Mechanisms(
            substeps_entry(self.plant, self.friction),
            MechanismVectors(*(matrix.ravel() for matrix in vectors)),
        )
        run, efforts = driver(open_loops), self._efforts(hold)
        matrices = np.full((3, self.count, len(self.effort)), np.nan)
        self.position, self.velocity, self.force = matrices
        records = Records(*matrices.reshape(3, -1), mechanisms=self.count)

        def work(first: int) -> None:
            run(
                mechanisms,
                first,
                min(first + width, self.count),
                efforts,
                float(dt),
                int(steps),
                records,
            )

        return work

    def _efforts(self, hold: str) -> Efforts:
        return Efforts(self.effort.ravel(), held(self.effort, hold).ravel(), self.effort.shape[1])

    def in_lanes(self, dt: float, steps: int, hold: str) -> Callable[[int], Any]:
        """Return the function that runs all trajectories of one block together."""
        widths = [
            matrix.shape[1] for matrix in (self.plants, self.body, self.frictions, self.state)
        ]
        rows, structures = Rows(*widths), (*self.plant.structures, *self.friction.structures)
        constants = lane_constants(structures[2], self.frictions)
        run = compiled(
            f"lanes-{self.plant.key}-{self.friction.key}-{'-'.join(map(str, widths))}-{constants.word}",
            lambda: make_lanes(*structures, rows, constants),
            InLanes,
            self.plant.functions + self.friction.functions,
            4,  # all vectors of a block at a time, for vectors of eight numbers
        )
        matrices = np.empty((3, len(self.effort), self.count))
        self.position, self.velocity, self.force = matrices.transpose(0, 2, 1)
        efforts, records = (
            self._efforts(hold),
            Records(*matrices.reshape(3, -1), mechanisms=self.count),
        )
        mechanisms = np.hstack((self.plants, self.body, self.frictions, self.state))

        def work(first: int) -> None:
            used = min(LANES, self.count - first)
            block = np.zeros((rows.count, LANES))
            block[: mechanisms.shape[1]] = mechanisms[
                np.minimum(np.arange(first, first + LANES), self.count - 1)
            ].T
            run(block.ravel(), np.zeros(0), first, used, efforts, float(dt), int(steps), records)
            self.out[first : first + used, FAILED_SO_FAR] = block[rows.failures_so_far, :used]
            for lane in np.flatnonzero(block[rows.lost_at, :used]):
                for record in (self.position, self.velocity, self.force):
                    record[first + lane, int(block[rows.lost_at, lane]) :] = np.nan

        return work

    def trace(self, dt: float) -> BatchTrace:
        """Return the trace of all trajectories."""
        finite = np.all(
            np.isfinite(self.position) & np.isfinite(self.velocity) & np.isfinite(self.force),
            axis=1,
        )
        inaccurate = self.out[:, FAILED_SO_FAR] > 0.0
        status = tuple(
            Status.SOLVE_INACCURATE if ok and bad else Status.OK if ok else Status.NOT_FINITE
            for ok, bad in zip(finite.tolist(), inaccurate.tolist(), strict=True)
        )
        return BatchTrace(
            dt * np.arange(len(self.effort)), self.position, self.velocity, self.force, status
        )


def _parameters(models: Sequence[Model], count: int, path: str) -> tuple[Instance, np.ndarray]:
    """Return a representative of all models, and their parameters, shape (trajectory, number)."""
    first, component = Instance(models[0]), models[0].component
    if is_scalar(first.structures[0]) and all(model.component is component for model in models):
        # One component and only numbers: no need to check each model.
        numbers = flattener(first.structures[0])
        rows = np.array([numbers(model.parameters) for model in models], dtype=float)
    else:
        rows = np.stack(
            [_row(first, model, f"{path}[{index}]") for index, model in enumerate(models)]
        )
    return first, np.array(np.broadcast_to(rows, (count, rows.shape[1])))


def _row(first: Instance, model: Model, path: str) -> np.ndarray:
    """Return the parameters of a model as numbers; refuse a model that does not match the first."""
    row = pack(model.parameters)
    if structure_of(model.parameters) != first.structures[0] or row.size != first.parameters.size:
        raise InputError(
            "has a different component or length than the first model",
            path=path,
            value=model.name,
            mend="Run a batch for each component and length",
        )
    return row
