"""Warp: the friction of thousands of joints in one array, for Newton and Isaac Lab, on a CPU or a graphics processor.

The functions are those of the export to CUDA. Warp accepts native code only inside a function, so they are members of a
local structure. The state of an axis ends with its parameters, which differ from axis to axis.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from bristle.apps.targets.cuda import CudaFiles, CudaPrinter
from bristle.core.errors import InputError
from bristle.exports import Product, Request
from bristle.exports.subject import settled_subject, subject_of
from bristle.exports.tunable import tunable_of


class WarpPrinter(CudaPrinter):
    """Prints functions as members of a local structure."""

    inline = absorbed = "static CUDA_CALLABLE inline"


class WarpFiles(CudaFiles):
    """Files of a model in Python with native code."""

    printer = WarpPrinter
    device = "static CUDA_CALLABLE "
    templates: ClassVar[Mapping[str, str]] = {
        "{}_warp.py": "warp/model.jinja",
        "{}_newton.py": "warp/newton.jinja",
        "{}_isaaclab.py": "warp/isaaclab.jinja",
        "README.md": "warp/README.md",
    }

    def lane_facts(self) -> dict[str, Any]:
        """Return the facts of the templates, with the parameters of an axis and their draws."""
        facts = super().lane_facts()
        request = self.request
        tuned = tunable_of(self.subject.model, self.fixed)
        numbers = {_flat(name, place): value for name, place, value in tuned.numbers()}
        drawn: Mapping[str, Any] = request.draws
        draws = {}
        for name, place, _ in tuned.numbers():
            if name in drawn:
                draws[_flat(name, place)] = (
                    np.asarray(drawn[name], dtype=float)
                    .reshape(len(drawn[name]), -1)[:, place or 0]
                    .tolist()
                )
        return facts | {
            "numbers": {name: _literal(value) for name, value in numbers.items()},
            "draws": {
                name: [_literal(value) for value in values] for name, values in draws.items()
            },
            "columns_named": [f"`{name}`" for name in numbers],
            "words": facts["bytes"] // 8,
            "step_size": repr(request.dt),
        }


def write(request: Request) -> Product:
    """Return the files; refuse a model whose parameters cannot differ between axes."""
    request = replace(request, axis=None, tunable=True, rest="middle")
    subject = subject_of(request.sampled)
    try:
        places = tunable_of(subject.model, WarpFiles.fixed).places
    except InputError as error:
        raise InputError(
            "has parameters that cannot differ between axes",
            path="warp",
            value=request.model.name,
            mend="Use cuda",
        ) from error
    product: dict[str, str | bytes] = dict(
        WarpFiles(settled_subject(subject, places), request).files()
    )
    return Product(
        product,
        (
            "the force is explicit: use a step shorter than sqrt(inertia / stiffness of the contact)",
        ),
    )


def _literal(value: float) -> str:
    if math.isfinite(value):
        return repr(value)
    return f'float("{value}")'


def _flat(name: str, place: int | None) -> str:
    if place is None:
        return name
    return f"{name}_{place}"
