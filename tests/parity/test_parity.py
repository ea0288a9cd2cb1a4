"""Plain Python, a process with the compiler switched off, and compiled code agree to the bit."""

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

from bristle import controllers, friction, sensors
from bristle.contract import example_of
from bristle.engine import force_along, interpreted, run_closed_loop, run_open_loop
from bristle.models.friction.preisach_lugre import KERNELS, TRANSITIONS
from bristle.models.plants import inertia

# Every slip law of the composite with one operator, and every operator with one slip law.
VARIANTS = {
    f"preisach_lugre, {kernel}, {transition}": {"kernel": kernel, "transition": transition}
    for kernel, transition in [(KERNELS[0], item) for item in TRANSITIONS[:2]]
    + [(item, "leuven") for item in KERNELS[1:]]
}
NAMES = [*friction.MODELS, *(f"{name}+asymmetry" for name in friction.MODELS), *VARIANTS]


# One of each kind of memory; with parameters by direction one more.
FAST = ("stribeck+asymmetry", "lugre", "maxwell_slip")


def model(name):
    base = name.partition(",")[0]
    result = example_of(friction.MODELS.get(base) or friction.find(base))
    return result.with_values(**VARIANTS.get(name, {}))


def runs(name):
    """Every driver on one model, with changes of direction, rests and a saturated controller."""
    generator = np.random.default_rng(11)
    friction_model = model(name)
    v = 10 ** generator.uniform(-6, -1, 120) * generator.choice((-1.0, 1.0), 120)
    v[::17] = 0.0
    along = force_along(friction_model, v, 1e-3)
    plant = inertia(M=2.0)
    t = 1e-3 * np.arange(150)
    effort = 60.0 * np.sin(60.0 * t) * (t > 0.02)
    zero = run_open_loop(plant, friction_model, effort, 1e-3, steps=3, v=0.01)
    linear = run_open_loop(plant, friction_model, effort, 1e-3, hold="linear")
    controller = controllers.cascade(k_p=60.0, k_v=500.0, k_i=2e4, limit=45.0, averaging=2)
    reference = np.zeros((4, t.size))
    reference[0] = 2e-3 * (1.0 - np.cos(40.0 * t))
    closed = run_closed_loop(
        plant,
        friction_model,
        controller,
        sensors.encoder(resolution=1e-7),
        reference,
        1e-3,
        steps=3,
        delay=1,
        injected=np.where(t > 0.1, 5.0, 0.0),
        limit=40.0,
    )
    static = (
        friction.with_presliding(friction_model, 2e-6)
        if friction.is_static(friction_model)
        else None
    )
    extra = force_along(static, v, 1e-3) if static else np.zeros(1)
    return [along, extra] + [
        getattr(trace, field)
        for trace in (zero, linear, closed)
        for field in ("position", "velocity", "effort", "friction", "measured", "command")
    ]


def digest(arrays):
    return hashlib.sha256(
        b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)
    ).hexdigest()


@pytest.mark.parametrize(
    "name", [name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in NAMES]
)
def test_plain_python_and_compiled_give_the_same_bits(name):
    compiled = runs(name)
    with interpreted():
        plain = runs(name)
    for a, b in zip(compiled, plain, strict=True):
        assert np.array_equal(a, b), np.max(np.abs(a - b))


@pytest.mark.slow
def test_a_process_without_the_compiler_gives_the_same_bits():
    code = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from test_parity import NAMES, digest, runs\n"
        "print('\\n'.join(digest(runs(name)) for name in NAMES))\n"
        "assert 'numba' not in sys.modules\n"
    )
    out = subprocess.run(
        [sys.executable, "-c", code, os.path.dirname(__file__)],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert out.returncode == 0, out.stderr
    assert out.stdout.split() == [digest(runs(name)) for name in NAMES]


GAINS = {"J": 2.0, "lambda_": 30.0, "K_1": 40.0, "cutoff": 200.0}
LAWS = {
    "sliding_mode": controllers.sliding_mode(**GAINS, K_2=2.0, phi=0.01),
    "super_twisting": controllers.super_twisting(**GAINS, k_1=0.5, k_2=5.0),
    "disturbance_observer": controllers.disturbance_observer(**GAINS, g=60.0),
    "lugre_observer": controllers.lugre_observer(
        **GAINS, F_C=1.0, F_S=1.2, v_S=1e-3, sigma_0=1e3, k=0.5
    ),
    "adaptive_hysteresis": controllers.adaptive_hysteresis(
        **GAINS, reach=1e-3, Gamma=500.0, w_max=2.0, delta=1e-5
    ),
}


@pytest.mark.parametrize(
    "name",
    [
        name if name == "sliding_mode" else pytest.param(name, marks=pytest.mark.slow)
        for name in LAWS
    ],
)
def test_plain_python_and_compiled_laws_give_the_same_bits(name):
    desired = np.zeros((4, 200))
    desired[0] = 1e-3 * np.sin(0.02 * np.arange(200))
    loop = inertia(M=2.0), example_of(friction.lugre), LAWS[name], sensors.encoder(), desired, 1e-3
    compiled = run_closed_loop(*loop)
    with interpreted():
        assert np.array_equal(compiled.command, run_closed_loop(*loop).command)
