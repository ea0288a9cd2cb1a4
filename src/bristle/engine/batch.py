"""Many mechanisms at once: parameter studies, Monte Carlo, identification by search."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.cores import Abreast, core_count
from bristle.core.edge import FLAG, Amount, among, array, guarded, many, model, optional, whole
from bristle.core.errors import InputError
from bristle.core.packing import LANES, flattener, is_scalar, lane_constants, pack, structure_of
from bristle.core.status import Status
from bristle.engine import lanes
from bristle.engine.checks import FRICTION, STEPS, check_integrator
from bristle.engine.compilation import compiled, driver, is_interpreted
from bristle.engine.entry_points import FAILED_SO_FAR, OUT_SIZE, MechanismVectors
from bristle.engine.implicit_lanes import ImplicitRows, make_implicit_lanes
from bristle.engine.instance import Instance
from bristle.engine.loop import HOLDS, INTEGRATOR, SAMPLE_TIME, held, substeps_entry
from bristle.engine.screwed import refuse_screw

__all__ = ["BatchTrace", "run_batch"]

# All vectors of a block at a time, where one holds eight numbers.
INTERLEAVED = 4
WORTH_LANES = 10_000_000  # steps in all: lanes of an implicit step are compiled apart, which takes seconds
KINDS: dict[str, tuple[Callable[..., Any], Callable[..., Any]]] = {
    "semi_implicit": (lanes.make_lanes, lanes.Rows),
    "efim": (make_implicit_lanes, ImplicitRows),
}
"""Integrator -> what makes the entry of a block, and its rows."""


@dataclass(frozen=True)
class BatchTrace:
    """What a batch leaves behind, in SI of the axis; arrays of shape (trajectory, sample).

    ``position`` and ``velocity`` are those at the instant of a sample; ``friction`` is the mean friction force until
    the next one. ``status`` has one entry for each trajectory; one that left the finite numbers is NaN from there.
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
    integrator=INTEGRATOR,
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
    integrator: str = "efim",
    x: Any = 0.0,
    v: Any = 0.0,
    threads: int | None = None,
    in_lanes: bool | None = None,
) -> BatchTrace:
    """Drive many mechanisms by recorded efforts, each as `run_open_loop` would, to the bit.

    Parameters
    ----------
    plant, friction : Model or sequence of Model
        The mechanisms: one for all trajectories, or one for each, of the same component.
    effort : array_like, shape (sample,) or (trajectory, sample)
        Effort [N or N*m] at each sample.
    dt : float
        Time between samples [s].
    steps : int
        Integration steps between two samples.
    hold : {"zero", "linear"}
        Between samples the effort is held, or runs straight to the next one.
    integrator : {"efim", "semi_implicit"}
        The implicit step, which sticks and takes long steps; or the semi-implicit one, of order 1 and for small steps,
        which runs in lanes: several trajectories in one instruction.
    x, v : array_like, shape () or (trajectory,)
        Position [m or rad] and velocity [m/s or rad/s] at the first sample.
    threads : int, optional
        Processor cores to use; all where not given.
    in_lanes : bool, optional
        Whether the implicit step runs in lanes, too, as it can where the friction model has no memory; where not given,
        from ten million steps on. The numbers are the same; lanes are compiled once for each kind of mechanism, and
        LuGre runs four times as fast in them.

    Returns
    -------
    BatchTrace
        Position, velocity and friction of each trajectory at each sample.

    Raises
    ------
    InputError
        If the numbers of models, efforts and starts disagree, or the models are not of one component.
    """
    batch, cores = _Batch(plant, friction, effort, x, v), threads or core_count()
    check_integrator(integrator, batch.friction.model)
    if in_lanes is None:
        in_lanes = batch.count * len(batch.effort) * steps >= WORTH_LANES
    if integrator == "efim" and not (in_lanes and batch.fits_lanes):
        # In lanes a block is as wide as they are; one by one it is a share of the work, so that no core waits.
        width = max(min(LANES, -(-batch.count // cores)), 1)
        work = batch.one_by_one(dt, steps, hold, width)
    else:
        width = LANES
        work = batch.in_lanes(dt, steps, hold, integrator)
    firsts = range(0, batch.count, width)
    if cores == 1 or len(firsts) == 1 or is_interpreted():
        for first in firsts:
            work(first)
    else:
        with Abreast(cores) as pool:
            list(pool.map(work, firsts))
    return batch.trace(dt)


class _Batch:
    """The mechanisms of a batch as vectors in a row, and their records."""

    def __init__(self, plant: Any, friction: Any, effort: Any, x: Any, v: Any) -> None:
        efforts, plants, frictions = np.atleast_2d(effort), plant, friction
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
            raise InputError(
                f"{', '.join(f'{number} {name}' for name, number in numbers.items())} do not make one batch",
                path="run_batch",
                mend="Give one of each for all trajectories, or one for each",
            )
        self.count = sizes.pop() if sizes else 1
        self.plant, self.plants = _parameters(plants, self.count, "plant")
        self.friction, self.frictions = _parameters(frictions, self.count, "friction")
        self.body = np.tile(self.plant.state, (self.count, 1))
        self.body[:, 0], self.body[:, 1] = x, v
        self.state = np.tile(self.friction.state, (self.count, 1))
        fresh = self.friction.component.new_memory(self.friction.model.parameters)
        self.memory = np.tile(fresh, (self.count, 1))
        # All trajectories of one sample lie side by side: what a block reads at a time.
        self.effort = np.ascontiguousarray(efforts.T)
        self.position, self.velocity, self.force = (np.empty((self.count, 0)) for _ in range(3))
        self.out = np.zeros((self.count, OUT_SIZE))

    def one_by_one(self, dt: float, steps: int, hold: str, width: int) -> Callable[[int], Any]:
        """Return what runs one block of so many by EFIM, trajectory by trajectory."""
        vectors = (self.plants, self.body, self.frictions, self.state, self.memory, self.out)
        mechanisms = lanes.Mechanisms(
            substeps_entry(self.plant, self.friction, "efim"), MechanismVectors(*(matrix.ravel() for matrix in vectors))
        )
        run, efforts = driver(lanes.open_loops), self._efforts(hold)
        records = self._records(self.count, len(self.effort))

        def work(first: int) -> None:
            last = min(first + width, self.count)
            run(mechanisms, first, last, efforts, float(dt), int(steps), records)

        return work

    def _efforts(self, hold: str) -> lanes.Efforts:
        return lanes.Efforts(self.effort.ravel(), held(self.effort, hold).ravel(), self.effort.shape[1])

    def _records(self, rows: int, columns: int, *, turned: bool = False) -> lanes.Records:
        """Return new records, each of such rows; `turned` where a row is one sample."""
        matrices = [np.empty((rows, columns)) if turned else np.full((rows, columns), np.nan) for _ in range(3)]
        self.position, self.velocity, self.force = (matrix.T if turned else matrix for matrix in matrices)
        x, v, force = (matrix.ravel() for matrix in matrices)
        return lanes.Records(x, v, force, self.count)

    @property
    def fits_lanes(self) -> bool:
        """Whether the implicit step can be done in lanes, and they are full: what is tried twice keeps no memory."""
        return self.count >= LANES and self.memory.shape[1] == 0

    def in_lanes(self, dt: float, steps: int, hold: str, integrator: str) -> Callable[[int], Any]:
        """Return what runs one block by one of the integrators, all its trajectories together."""
        size = self.memory.shape[1]
        widths = [matrix.shape[1] for matrix in (self.plants, self.body, self.frictions, self.state)]
        make, rows = KINDS[integrator][0], KINDS[integrator][1](*widths)
        structures = (*self.plant.structures, *self.friction.structures)
        constants = lane_constants(structures[2], self.frictions)
        layout = "-".join(map(str, (*widths, size > 0, constants.word)))
        run = compiled(
            f"lanes-{integrator}-{self.plant.key}-{self.friction.key}-{layout}",
            lambda: make(*structures, rows, size > 0, constants),
            lanes.InLanes,
            self.plant.functions + self.friction.functions,
            INTERLEAVED,
        )
        efforts, records = self._efforts(hold), self._records(len(self.effort), self.count, turned=True)
        mechanisms = np.hstack((self.plants, self.body, self.frictions, self.state))

        def work(first: int) -> None:
            used = min(LANES, self.count - first)
            chosen = np.minimum(np.arange(first, first + LANES), self.count - 1)
            block = np.zeros((rows.count, LANES))
            block[: mechanisms.shape[1]] = mechanisms[chosen].T
            run(block.ravel(), self.memory[chosen].ravel(), size, first, used, efforts, float(dt), int(steps), records)
            self.out[first : first + used, FAILED_SO_FAR] = block[rows.failures_so_far, :used]
            for lane in np.flatnonzero(block[rows.lost_at, :used]):
                for record in (self.position, self.velocity, self.force):
                    record[first + lane, int(block[rows.lost_at, lane]) :] = np.nan

        return work

    def trace(self, dt: float) -> BatchTrace:
        """Return what the trajectories left behind."""
        finite = np.all(np.isfinite(self.position) & np.isfinite(self.velocity) & np.isfinite(self.force), axis=1)
        inaccurate = self.out[:, FAILED_SO_FAR] > 0.0
        status = tuple(
            Status.SOLVE_INACCURATE if ok and bad else Status.OK if ok else Status.NOT_FINITE
            for ok, bad in zip(finite.tolist(), inaccurate.tolist(), strict=True)
        )
        return BatchTrace(dt * np.arange(len(self.effort)), self.position, self.velocity, self.force, status)


def _parameters(models: Sequence[Model], count: int, path: str) -> tuple[Instance, np.ndarray]:
    """Return the part that stands for all models, and their parameters, shape (trajectory, number)."""
    first, component = Instance(models[0]), models[0].component
    if is_scalar(first.structures[0]) and all(model.component is component for model in models):
        # One component and nothing but numbers: no need to look into each.
        numbers = flattener(first.structures[0])
        rows = np.array([numbers(model.parameters) for model in models], dtype=float)
    else:
        rows = np.stack([_row(first, model, f"{path}[{index}]") for index, model in enumerate(models)])
    return first, np.array(np.broadcast_to(rows, (count, rows.shape[1])))


def _row(first: Instance, model: Model, path: str) -> np.ndarray:
    """Return the parameters of a model as numbers; refuse one that does not fit the first."""
    row = pack(model.parameters)
    if structure_of(model.parameters) != first.structures[0] or row.size != first.parameters.size:
        raise InputError(
            "is of another component, or has lists of another length, than the first",
            path=path,
            value=model.name,
            mend="Run one batch for each",
        )
    return row
