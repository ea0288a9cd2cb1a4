r"""Friction along walks for frameworks of automatic differentiation, with a compiled model.

.. math:: (s_k, F_k) = g(s_{k-1}, x_k, \Delta t, p), \qquad
   \bar s_{k-1} = \left(\frac{\partial s_k}{\partial s_{k-1}}\right)^T \bar s_k
   + \left(\frac{\partial F_k}{\partial s_{k-1}}\right)^T \bar F_k

with the state :math:`s` including the memory. In reverse mode, a walk is recomputed in segments from stored states.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any, ClassVar

import numpy as np

from bristle.core import InputError, MissingExtraError, Model, did_you_mean
from bristle.exports import CompiledWalk


class CompiledFriction(ABC):
    """A friction model of a framework; `walk` and `force` are differentiable in all their numbers.

    Leading axes of all arguments are lanes, which broadcast. The derivatives are those of `bristle.engine.derivatives`:
    exact, of the executed branches. All numbers are in SI units and of double precision, on the CPU. A refused input,
    such as ``dt=0`` or a parameter outside its range, repeats the last force and its derivatives.

    Parameters
    ----------
    model : Model
        A friction model with parameters. The C compiler of this machine compiles it at first use.

    Attributes
    ----------
    model : Model
        The friction model.
    parameters : dict of str to float or ndarray
        Values of its parameters, which can be arguments of `walk` and `force`.

    Raises
    ------
    InputError
        If bristle does not export derivatives of the model, or finds no C compiler.
    MissingExtraError
        If the framework is not installed.
    """

    framework: ClassVar[str]
    """Module of the framework, with functions named as in numpy."""

    def __init__(self, model: Model) -> None:
        try:
            self._numpy = import_module(self.framework)
        except ImportError as error:
            extra = self.framework.partition(".")[0]
            raise MissingExtraError.of(f"friction in {extra}", extra) from error
        self.model, self._walk = model, CompiledWalk(model)
        self.parameters = {name: model.values[name] for name in self._walk.parameters}

    def start(self) -> Any:
        """Return the state of a virgin contact before the first sample, shape (number,).

        The first sample sets the position, and its force is 0.
        """
        return self._array(self._walk.start, "start")

    def walk(self, state: Any, x: Any, dt: Any, parameters: Any = None, **signals: Any) -> tuple[Any, Any]:
        """Return the state after a walk, and the friction force of each step.

        Parameters
        ----------
        state : array, shape (..., number)
            State before the walk, from `start` or an earlier call.
        x : array, shape (..., step)
            Position at the end of each step [m or rad].
        dt : array, shape (...)
            Time step [s].
        parameters : mapping or array, shape (..., parameter), optional
            Some parameters by name, or all their numbers in the order of `parameters`; those of the model by default.
        **signals : array, shape (..., step)
            Inputs of friction besides the motion, such as ``load`` and ``temperature``; nominal values by default.

        Returns
        -------
        state : array, shape (..., number)
            State after the walk.
        force : array, shape (..., step)
            Mean friction force of each step [N or N*m].

        Raises
        ------
        InputError
            If an argument is not of double precision, or has the wrong shape or an unknown name.
        """
        walk = self._walk
        for kind, names, allowed in (("signals", signals, walk.signals), ("parameters", parameters, walk.parameters)):
            for name in set(names) - set(allowed) if isinstance(names, Mapping) else ():
                raise InputError(
                    "no such name", path=kind, value=name, mend=did_you_mean(name, allowed), allowed=", ".join(allowed) or f"no {kind}"
                )
        around = [self._array(signals.get(name, usual), name) for name, usual in walk.signals.items()]
        x = self._array(x, "x")
        operands = [self._array(state, "state"), x, self._array(dt, "dt")[..., None], self._flat(parameters)]
        operands += [signal if signal.shape else signal[None] for signal in around]
        widths = [walk.start.size, x.shape[-1], 1, sum(map(np.size, walk.parameters.values())), *[x.shape[-1]] * len(around)]
        names = ["state", "x", "dt", "parameters", *walk.signals]
        for name, operand, width in zip(names, operands, widths, strict=True):
            if operand.shape[-1] != width and not (name in walk.signals and operand.shape[-1] == 1):
                raise InputError("has a wrong shape", path=name, value=tuple(operand.shape), allowed=f"(..., {width})")
        lanes = np.broadcast_shapes(*(operand.shape[:-1] for operand in operands))
        pairs = zip(operands, widths, strict=True)
        return self._run([self._numpy.broadcast_to(operand, (*lanes, width)) for operand, width in pairs])

    def force(self, state: Any, x: Any, dt: Any, parameters: Any = None, **signals: Any) -> tuple[Any, Any]:
        """Return the state after one step, and its force: `walk` with a position and signals of shape (...)."""
        signals = {name: self._array(signal, name)[..., None] for name, signal in signals.items()}
        state, force = self.walk(state, self._array(x, "x")[..., None], dt, parameters, **signals)
        return state, force[..., 0]

    def _flat(self, parameters: Any) -> Any:
        """Return the numbers of all parameters."""
        if parameters is not None and not isinstance(parameters, Mapping):
            return self._array(parameters, "parameters")
        parts = []
        for name, usual in self.parameters.items():
            part = self._array((parameters or {}).get(name, usual), name)
            parts.append(part if isinstance(usual, np.ndarray) else part[..., None])
        lanes = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
        return self._numpy.concatenate([self._numpy.broadcast_to(part, (*lanes, part.shape[-1])) for part in parts], -1)

    @abstractmethod
    def _array(self, value: Any, name: str) -> Any:
        """Return an array of the framework; refuse other numbers than those of double precision."""

    @abstractmethod
    def _run(self, operands: Sequence[Any]) -> tuple[Any, Any]:
        """Return the state and the force of a walk."""
