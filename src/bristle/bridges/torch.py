"""Friction in PyTorch, differentiable along walks."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from bristle.bridges.compiled import CompiledFriction
from bristle.core import InputError, MissingExtraError

try:
    import torch
except ImportError as error:
    raise MissingExtraError.of("friction in PyTorch", "torch") from error


class Friction(CompiledFriction):
    """A friction model in PyTorch, for tensors of double precision on the CPU.

    Examples
    --------
    >>> from bristle import friction
    >>> dahl = Friction(friction.dahl(F_C="20 N", sigma_0="10 N/um"))
    >>> F_C = torch.tensor(20.0, dtype=torch.float64, requires_grad=True)
    >>> _, force = dahl.walk(dahl.start(), torch.linspace(0.0, 1e-4, 50, dtype=torch.float64), 1e-3, {"F_C": F_C})
    >>> force[-1].backward()
    >>> round(F_C.grad.item(), 6)
    1.0
    """

    library = torch

    def _array(self, value: Any, name: str) -> Any:
        tensor = value if isinstance(value, torch.Tensor) else torch.as_tensor(np.asarray(value, dtype=float))
        if tensor.dtype != torch.float64 or tensor.device.type != "cpu":
            raise InputError(
                "must be of double precision on the CPU",
                path=name,
                value=f"{tensor.dtype} on {tensor.device}",
                allowed="torch.float64 on cpu",
                mend=f"Write {name}.double().cpu()",
            )
        return tensor

    def _run(self, operands: Sequence[Any]) -> tuple[Any, Any]:
        return _Walk.apply(self._walk, *operands)  # type: ignore[no-any-return]


class _Walk(torch.autograd.Function):
    """A walk with its derivatives in reverse."""

    @staticmethod
    def forward(ctx: Any, walk: Any, *operands: Any) -> tuple[Any, Any]:
        ctx.walk = walk
        ctx.save_for_backward(*operands)
        return _computed("walk", walk, operands, operands[:2])

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, *adjoints: Any) -> tuple[Any, ...]:
        return None, *_computed("walk_reverse", ctx.walk, [*ctx.saved_tensors, *adjoints], ctx.saved_tensors)


def _computed(function: str, walk: Any, operands: Sequence[Any], like: Sequence[Any]) -> tuple[Any, ...]:
    """Return the results of a function of the library, with the shapes of some tensors."""
    outputs = [torch.empty(tensor.shape, dtype=torch.float64) for tensor in like]
    inputs = [operand.detach().contiguous().numpy() for operand in operands]
    *lanes, steps = operands[1].shape
    walk.run(function, int(np.prod(lanes)), steps, inputs, [output.numpy() for output in outputs])
    return tuple(outputs)
