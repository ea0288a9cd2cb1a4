"""Friction along walks as a function of PyTorch, with exact gradients in reverse mode.

Needs PyTorch and a C compiler. All numbers are of double precision, on the CPU.
"""

import torch


def ran(walk, function, inputs, like):
    """Return what a function of a compiled walk writes, in tensors of these shapes."""
    outputs = tuple(torch.empty(part.shape, dtype=torch.float64) for part in like)
    arrays = [part.detach().contiguous().numpy() for part in inputs]
    walk.run(function, *inputs[1].shape, arrays, [part.numpy() for part in outputs])
    return outputs


class Walk(torch.autograd.Function):
    @staticmethod
    def forward(ctx, walk, *inputs):
        ctx.walk = walk
        ctx.save_for_backward(*inputs)
        return ran(walk, "walk", inputs, inputs[:2])

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx, *adjoints):
        saved = ctx.saved_tensors
        return None, *ran(ctx.walk, "walk_reverse", [*saved, *adjoints], saved)


def force(walk, x, dt, numbers):
    """Return the force of each step along positions `x` of shape (axis, step), `dt` apart.

    `walk` is bristle.exports.CompiledWalk(model), and `numbers` are those of walk.parameters.
    """
    parts = [torch.from_numpy(walk.start), dt, numbers]
    start, dt, numbers = (part.expand(len(x), -1) for part in parts)
    signals = [torch.full_like(x, usual) for usual in walk.signals.values()]
    return Walk.apply(walk, start, x, dt, numbers, *signals)[1]
