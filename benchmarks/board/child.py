"""A competitor in a process of its own: it receives records without the effort to predict, and has a time limit."""

from __future__ import annotations

import io
import os
import pickle
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from benchmarks.board.record import MEASURED, Data, Record
from bristle.core import BristleError, Content, Model, error_text

RAISED, NOT_FINITE, SHAPE, SLOW, CRASHED, ABSENT = (
    "raised",
    "not finite",
    "wrong shape",
    "too slow",
    "crashed",
    "not entered",
)
NEEDED = {
    "predict": "predict",
    "loop": "predict",
    "feedforward": "feedforward",
    "parameters": "parameters",
}
"""Function of a competitor behind each answer."""
WALL = 4.0  # waiting time over processor time: other programs may use the cores
STARTS = 30.0  # [s] more waiting time, for the start
PATIENCE = 1.0  # [s] between checks that the parent is alive
REASON = 200  # letters
OWN = "bristle_user_competitor"
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@dataclass(frozen=True)
class Fault:
    """Reason of a missing answer."""

    status: str
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Orders:
    """Content of a competitor's file, the answers to give, and the records, without any effort of a test."""

    code: Content
    names: tuple[str, ...]
    train: Sequence[Record]
    motions: Sequence[Record]
    reference: Record | None
    loop_mass: float

    @classmethod
    def of(cls, code: Content, names: Sequence[str], data: Data) -> Orders:
        """Return the orders for the data of a case."""
        return cls(
            code,
            tuple(names),
            data.train,
            [record.motion for record in data.test],
            data.reference,
            data.loop_mass,
        )


def answers(orders: Orders, limit: float) -> dict[str, Any]:
    """Return the answers of a competitor, each as its value or a `Fault`; the process has `limit` seconds of processor time."""
    code = f"import sys; sys.path[:] = {sys.path!r}; from benchmarks.board.child import serve; serve({limit!r})"
    # The folder of the measured logs would show the efforts of the tests.
    surroundings = {
        name: value for name, value in os.environ.items() if name != MEASURED
    } | ONE_THREAD
    missing = Fault(SLOW, f"used more than {limit:g} s")
    command = [sys.executable, "-c", code]
    with subprocess.Popen(
        command, stdin=-1, stdout=-1, stderr=subprocess.DEVNULL, env=surroundings
    ) as process:
        try:
            output, _ = process.communicate(pickle.dumps(orders), timeout=WALL * limit + STARTS)
        except subprocess.TimeoutExpired:
            process.kill()
            output, _ = process.communicate()
        except BaseException:
            process.kill()
            raise
        else:
            if process.returncode not in (-24, 0):  # of the signal for spent processor time
                missing = Fault(CRASHED, f"the process ended with code {process.returncode}")
    replies, stream = dict[str, Any](), io.BytesIO(output)
    with suppress(EOFError, pickle.UnpicklingError):  # the process ended within an answer
        while True:
            name, answer = pickle.load(stream)
            replies[name] = answer
    return {name: replies.get(name, replies.get("fit", missing)) for name in orders.names}


def serve(limit: float) -> None:
    """Answer the orders on the standard input as a process of its own."""
    stream = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # keep prints of the competitor out of the answers
    orders, parent = pickle.load(sys.stdin.buffer), os.getppid()
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    if os.name == "posix":  # elsewhere the waiting time ends the process
        import resource

        spent = int(time.process_time() + limit) + 1
        with suppress(ValueError, OSError):  # the user has set a smaller limit
            resource.setrlimit(resource.RLIMIT_CPU, (spent, spent + 5))
    for message in answered(orders):
        stream.write(pickle.dumps(message))
    os._exit(0)  # threads of the competitor may still run


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(PATIENCE)
    os._exit(1)


def answered(orders: Orders) -> Iterator[tuple[str, Any]]:
    """Yield each answer by name; the fault of a failed fit is the answer `fit`."""
    module = sys.modules[OWN] = ModuleType(OWN)
    try:
        exec(compile(orders.code.data, str(orders.code.source), "exec"), module.__dict__)
        fitted = _fit(module, orders.train)
    except BaseException as error:  # noqa: BLE001  (any fault of a competitor becomes a row)
        yield "fit", _fault(error, str(orders.code.source))
        return
    calls: dict[str, Callable[[], Any]] = {
        "predict": lambda: [_predicted(module, fitted, motion) for motion in orders.motions],
        "loop": lambda: _loop(module, fitted, orders.reference, orders.loop_mass),
        "feedforward": lambda: _fed(module.feedforward(fitted, orders.reference), orders.reference),
        "parameters": lambda: {
            str(name): float(value) for name, value in dict(module.parameters(fitted)).items()
        },
    }
    for name in orders.names:
        try:
            yield name, calls[name]() if hasattr(module, NEEDED[name]) else Fault(ABSENT)
        except BaseException as error:  # noqa: BLE001
            yield name, _fault(error, str(orders.code.source))


def _fault(error: BaseException, file: str) -> Fault:
    """Return the fault behind an error, with the last line of the competitor in its traceback."""
    if isinstance(error, _AnswerError):
        return Fault(error.status, str(error))
    text = (
        error_text(error)
        if isinstance(error, BristleError)
        else f"{type(error).__name__}: {error_text(error)}"
    )
    lines = [
        frame.lineno
        for frame in traceback.extract_tb(error.__traceback__)
        if frame.filename == file
    ]
    return Fault(RAISED, (f"line {lines[-1]}: " if lines else "") + text[:REASON])


class _AnswerError(Exception):
    def __init__(self, status: str, reason: str) -> None:
        super().__init__(reason)
        self.status = status


def _array(values: Any, record: Record | None) -> np.ndarray:
    """Return an answer as an array like the positions of its record; refuse others."""
    assert record is not None
    array = np.asarray(values, dtype=float)
    if array.shape != record.position.shape:
        raise _AnswerError(
            SHAPE, f"returned the shape {array.shape} instead of {record.position.shape}"
        )
    if not np.all(np.isfinite(array)):
        raise _AnswerError(
            NOT_FINITE,
            f"{np.count_nonzero(~np.isfinite(array))} of {array.size} values are not finite",
        )
    return array


def _fed(answer: Any, reference: Record | None) -> tuple[Model | None, np.ndarray | None]:
    """Return the controller and the feedforward of an answer, which is either, or both."""
    law, *efforts = (
        answer
        if isinstance(answer, tuple)
        else (answer,)
        if isinstance(answer, Model)
        else (None, answer)
    )
    return law, _array(efforts[0], reference) if efforts else None


def _fit(module: ModuleType, train: Sequence[Record]) -> Any:
    """Return the fit of a competitor; of an arm without `fit_arm`, a fit for each joint."""
    if not train[0].robot:
        return module.fit(train)
    if hasattr(module, "fit_arm"):
        return module.fit_arm(train)
    return [
        module.fit(list(records))
        for records in zip(*(record.joints for record in train), strict=True)
    ]


def _predicted(module: ModuleType, fitted: Any, motion: Record) -> np.ndarray:
    if not motion.robot:
        return _array(module.predict(fitted, motion), motion)
    if hasattr(module, "fit_arm"):
        return _array(module.predict_arm(fitted, motion), motion)
    return np.column_stack(
        [
            _array(module.predict(fit, part), part)
            for fit, part in zip(fitted, motion.joints, strict=True)
        ]
    )


def _loop(module: ModuleType, fitted: Any, reference: Record | None, mass: float) -> np.ndarray:
    """Return the following error of the loop with the predicted effort as its axis."""
    from benchmarks.board.loop import following_error

    assert reference is not None
    error = following_error(
        lambda motion: _array(module.predict(fitted, motion), motion), reference, mass
    )
    if not np.all(np.isfinite(error)):
        raise _AnswerError(NOT_FINITE, "the loop with this axis diverges")
    return error
