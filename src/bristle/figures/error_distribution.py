"""How often the following error has which size, loop by loop to one scale, with mean and standard deviation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.labels import scale_for

if TYPE_CHECKING:
    from bristle.simulation.result import VariantResult

__all__ = ["error_distribution"]

RANGE = "range in the paper"


@style.styled
def error_distribution(
    results: Mapping[str, VariantResult],
    settle: float,
    resolution: float,
    published: Mapping[str, tuple[float, float]] | None = None,
    kind: Kind = "translational",
) -> Figure:
    """Return the distribution of the following error, a panel for each loop.

    Parameters
    ----------
    results : mapping of str to VariantResult
        Loops by the name above their panel.
    settle : float
        Time at the start that is left out [s].
    resolution : float
        One count of the encoder [m or rad]; a bar is half as wide. Without one the range is cut into sixty.
    published : mapping of str to (float, float), optional
        Ranges to compare with, by the name of the loop [m or rad].
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    errors = {name: (result.reference - result.measured)[result.time >= settle] for name, result in results.items()}
    low, high = (min(float(error.min()) for error in errors.values()), max(float(error.max()) for error in errors.values()))
    length = scale_for("length", kind, *(result.reference for result in results.values()))
    width = 0.5 * resolution if resolution > 0.0 else (high - low) / 60.0
    edges = np.arange(np.floor(low / width), np.ceil(high / width) + 1.0) * width * length.factor
    figure, (row,) = style.panels(3.0, columns=len(results), between=0.3, top=0.56)
    shares = {name: np.histogram(error * length.factor, edges)[0] * (100.0 / error.size) for name, error in errors.items()}
    top = 1.08 * max(float(share.max()) for share in shares.values())
    for column, (axes, (name, error)) in enumerate(zip(row, errors.items(), strict=True)):
        mean, std = float(error.mean()) * length.factor, float(error.std()) * length.factor
        axes.axvspan(mean - std, mean + std, color="#e9ecf0", linewidth=0, zorder=0, label="mean ± standard deviation")
        axes.stairs(shares[name], edges, fill=True, color="#9db6d0", label="_bars")
        axes.stairs(shares[name], edges, color=style.PREDICTED["color"], linewidth=0.9, label="_outline")
        axes.axvline(mean, color=style.INK, linewidth=1.2, linestyle="--", label="mean")
        for edge, label in zip((published or {}).get(name, ()), (RANGE, "_same"), strict=False):
            axes.axvline(edge * length.factor, color=style.GREY, linewidth=1.2, linestyle=(0, (1, 1.5)), label=label)
        style.title(axes, name)
        axes.set_ylim(0.0, top)
        axes.set_xlabel(length.label("Following error"))
        if column:
            axes.tick_params(labelleft=False)
        else:
            axes.set_ylabel("Share of the samples [%]")
    style.legend_in_corner(figure, row[0])
    return figure
