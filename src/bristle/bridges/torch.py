"""Friction in PyTorch, differentiable along walks."""

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from bristle.bridges.compiled import CompiledFriction
from bristle.core import InputError


class Friction(CompiledFriction):
    """A friction model in PyTorch, for tensors of double precision on the CPU.

    It has gradients in reverse mode of first order.
    """

    framework = "torch"

    def _array(self, value: Any, name: str) -> Any:
        torch = self._numpy
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
        return _walk_function(self._numpy).apply(self._walk, *operands)


@cache
def _walk_function(torch: Any) -> Any:
    """Return the function of a walk with its derivatives in reverse."""

    def computed(function: str, walk: Any, operands: Sequence[Any], like: Sequence[Any]) -> tuple[Any, ...]:
        """Return the results of a function of the library, with the shapes of some tensors."""
        outputs = [torch.empty(tensor.shape, dtype=torch.float64) for tensor in like]
        inputs = [operand.detach().contiguous().numpy() for operand in operands]
        *lanes, steps = operands[1].shape
        walk.run(function, int(np.prod(lanes)), steps, inputs, [output.numpy() for output in outputs])
        return tuple(outputs)

    class Walk(torch.autograd.Function):
        @staticmethod
        def forward(ctx: Any, walk: Any, *operands: Any) -> tuple[Any, ...]:
            ctx.walk = walk
            ctx.save_for_backward(*operands)
            return computed("walk", walk, operands, operands[:2])

        @staticmethod
        @torch.autograd.function.once_differentiable
        def backward(ctx: Any, *adjoints: Any) -> tuple[Any, ...]:
            return None, *computed("walk_reverse", ctx.walk, [*ctx.saved_tensors, *adjoints], ctx.saved_tensors)

    return Walk
