"""Files for drives, without the simulation of what they do to an axis, and the rows of them."""

import numpy as np

import bristle as br
from bristle.exports.described import Request
from bristle.exports.targets import TARGETS

TURNING = {
    "schema": 1,
    "kind": "rotational",
    "columns": {
        "time": {"column": "t", "unit": "s"},
        "position": {"column": "q", "unit": "deg"},
        "effort": {"column": "u", "unit": "%"},
    },
    "effort": {"rated": "0.5 N*m"},
}
LINEAR = {
    "schema": 1,
    "kind": "translational",
    "columns": {
        "time": {"column": "t", "unit": "s"},
        "position": {"column": "q", "unit": "mm"},
        "effort": {"column": "u", "unit": "A"},
    },
    "effort": {"force_constant": "50 N/A"},
}
SCREW = LINEAR | {
    "columns": LINEAR["columns"] | {"effort": {"column": "u", "unit": "N"}},
    "effort": {"rated": "2 N*m"},
    "transmission": {"lead": "10 mm", "gear_ratio": 2.0},
}
ARM = 0.01 / (2.0 * np.pi * 2.0)  # of the screw behind its gear [m/rad]
STRIBECK = br.friction.find("stribeck")(F_C=8.0, F_S=11.0, v_S=4e-3, F_v=30.0, offset=2.5)


def product_of(target, model=STRIBECK, axis=None, **options):
    """Return what a target writes of a model, for an axis as in its file."""
    options = {"speed": 0.2, "rest": "held"} | options
    return TARGETS[target].write(
        Request(model, "axis_x", 1e-3, axis=axis and br.read_axis(axis), **options)
    )


def rows_of(product, end="axis_x.csv", separator=","):
    """Return the cells of each line that is no comment."""
    return [
        line.split(separator)
        for line in product.files[end].splitlines()
        if not line.startswith(("#", ";"))
    ]


def listed(product):
    """Return the values of a list for the CNC by their keys."""
    return {
        key.removeprefix("frict_comp."): float(value)
        for key, value in rows_of(product, "axis_x.txt", None)
    }
