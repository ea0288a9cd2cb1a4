"""A competitor in a process of its own: it receives records without the effort to predict, and has a time limit."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.bench.record import MEASURED, Record
from bristle.core import BristleError, Content, told_by

if TYPE_CHECKING:
    from bristle.bench.task import Data

RAISED, NOT_FINITE, SHAPE, SLOW, CRASHED, ABSENT = "raised", "not finite", "wrong shape", "too slow", "crashed", "not entered"
WALL = 6.0  # waiting time over processor time: other programs may use the cores
PATIENCE = 1.0  # [s] between checks that the parent is alive
REASON = 200  # letters
OWN = "bristle_user_competitor"
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@dataclass(frozen=True)
class Fault:
    """Reason why an answer is missing."""

    status: str
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Orders:
    """Content of a competitor's file, its records, and the functions to call; no effort of a test record."""

    code: Content
    functions: tuple[str, ...]
    train: Sequence[Record]
    motions: Sequence[Record]
    reference: Record | None
    loop_mass: float

    @classmethod
    def of(cls, code: Content, functions: Sequence[str], data: Data) -> Orders:
        """Return the orders for the data of a case."""
        return cls(code, tuple(functions), data.train, [record.motion for record in data.test], data.reference, data.loop_mass)


def answers(orders: Orders, limit: float) -> dict[str, Any]:
    """Return the answers of a competitor by function, or a `Fault`; the process has `limit` seconds of processor time."""
    code = f"import sys; sys.path[:] = {sys.path!r}; from bristle.bench.child import serve; serve({limit!r})"
    surroundings = {name: value for name, value in os.environ.items() if name != MEASURED} | ONE_THREAD
    missing = Fault(SLOW, f"used more than {limit:g} s")
    try:
        ended = subprocess.run(
            [sys.executable, "-c", code],
            input=pickle.dumps(orders, protocol=pickle.HIGHEST_PROTOCOL),
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=WALL * limit,
            env=surroundings,
            check=False,
        )
        output = ended.stdout
        if ended.returncode and not _is_limit(ended.returncode):
            missing = Fault(CRASHED, f"process ended with code {ended.returncode}")
    except subprocess.TimeoutExpired as expired:
        output = expired.stdout or b""
    found: dict[str, Any] = dict(_messages(output))
    return {name: found.get("fit", missing) if name not in found else found[name] for name in orders.functions}


def _is_limit(code: int) -> bool:
    import signal

    return code in {-getattr(signal, name) for name in ("SIGXCPU", "SIGKILL") if hasattr(signal, name)}


def _messages(output: bytes) -> Iterator[tuple[str, Any]]:
    import io

    stream = io.BytesIO(output)
    while stream.tell() < len(output):
        try:
            yield pickle.load(stream)
        except Exception:  # noqa: BLE001  (the process ended within a message)
            return


def serve(limit: float) -> None:
    """Answer the orders on the standard input as a process of its own."""
    stream = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # keep prints of the competitor out of the answers
    orders = pickle.load(sys.stdin.buffer)
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    try:
        import resource

        used = time.process_time()
        resource.setrlimit(resource.RLIMIT_CPU, (int(used + limit) + 1, int(used + limit) + 5))
    except ImportError:  # no such limits on this system: the waiting time ends the process
        pass
    for message in answered(orders):
        pickle.dump(message, stream, protocol=pickle.HIGHEST_PROTOCOL)
        stream.flush()
    stream.flush()
    os._exit(0)  # threads of the competitor may still run


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(PATIENCE)
    os._exit(1)


def answered(orders: Orders) -> Iterator[tuple[str, Any]]:
    """Yield the answer to each function; a failed fit is the answer to all."""
    module = sys.modules[OWN] = ModuleType(OWN)
    try:
        exec(compile(orders.code.data, str(orders.code.source), "exec"), module.__dict__)
        fits = hasattr(module, "fit_arm") and orders.train[0].robot
        absent = {name for name in orders.functions if not hasattr(module, NEEDED[name])}
        yield from ((name, Fault(ABSENT)) for name in absent)
        fitted = None if absent == set(orders.functions) else _fit(module, orders.train, as_arm=bool(fits))
    except BaseException as error:  # noqa: BLE001  (any fault of a competitor becomes a row)
        yield "fit", _fault(error)
        return
    calls: dict[str, Callable[[], Any]] = {
        "predict": lambda: [_predicted(module, fitted, motion) for motion in orders.motions],
        "loop": lambda: _loop(module, fitted, orders),
        "feedforward": lambda: _array(module.feedforward(fitted, orders.reference), orders.reference),
        "parameters": lambda: {str(name): float(value) for name, value in dict(module.parameters(fitted)).items()},
    }
    for name in orders.functions:
        if name not in absent:
            try:
                yield name, calls[name]()
            except BaseException as error:  # noqa: BLE001
                yield name, _fault(error)


NEEDED = {"predict": "predict", "loop": "predict", "feedforward": "feedforward", "parameters": "parameters"}
"""Function of a competitor behind each answer."""


def _fault(error: BaseException) -> Fault:
    if isinstance(error, _AnswerError):
        return Fault(error.status, str(error))
    text = told_by(error) if isinstance(error, BristleError) else f"{type(error).__name__}: {told_by(error)}"
    return Fault(RAISED, text[:REASON])


class _AnswerError(Exception):
    def __init__(self, status: str, reason: str) -> None:
        super().__init__(reason)
        self.status = status


def _array(values: Any, record: Record | None) -> np.ndarray:
    """Return an answer as an array like the positions of its record; refuse others."""
    assert record is not None
    array = np.asarray(values, dtype=float)
    if array.shape != record.position.shape:
        raise _AnswerError(SHAPE, f"returned shape {array.shape}, not {record.position.shape}")
    if not np.all(np.isfinite(array)):
        raise _AnswerError(NOT_FINITE, f"{np.count_nonzero(~np.isfinite(array))} of {array.size} values are not finite")
    return array


def _fit(module: ModuleType, train: Sequence[Record], *, as_arm: bool) -> Any:
    """Return the fit of a competitor; of an arm without `fit_arm`, a fit for each joint."""
    if as_arm:
        return module.fit_arm(train)
    if not train[0].robot:
        return module.fit(train)
    return [module.fit(list(records)) for records in zip(*(record.joints for record in train), strict=True)]


def _predicted(module: ModuleType, fitted: Any, motion: Record) -> np.ndarray:
    if not motion.robot:
        return _array(module.predict(fitted, motion), motion)
    if hasattr(module, "fit_arm"):
        return _array(module.predict_arm(fitted, motion), motion)
    return np.column_stack([_array(module.predict(fit, part), part) for fit, part in zip(fitted, motion.joints, strict=True)])


def _loop(module: ModuleType, fitted: Any, orders: Orders) -> np.ndarray:
    """Return the following error of the loop with the predicted effort as its axis."""
    from bristle.bench.loop import following_error

    assert orders.reference is not None
    error = following_error(lambda motion: _array(module.predict(fitted, motion), motion), orders.reference, orders.loop_mass)
    if not np.all(np.isfinite(error)):
        raise _AnswerError(NOT_FINITE, "the loop with this axis diverges")
    return error
