"""What a file with a slot of a person's own must be, what its force is, and where it goes."""

import pickle
from pathlib import Path

import numpy as np
import pytest
import tomlkit
from tests.exports.native import COMPILER
from tests.files.own_slot import AXIS, DT, SLOT, write_bench

import bristle as br
from bristle.core import InputError
from bristle.core.errors import InputWarning
from bristle.engine import force_along, interpreted
from bristle.files import (
    load_slot_file,
    read_axis,
    read_experiment,
    read_log,
    read_model,
    write_model,
)
from bristle.models.friction import (
    base_of,
    channel_slots_of,
    coulomb_viscous,
    find,
    lugre,
    unvaried,
    with_presliding,
    with_slots,
)

CHANNEL = (
    'Surrounding("pressure", Variable("force/length^2", "pressure of the oil", min=0.0), usual=2e5)'
)
V, PRESSURE = np.array([0.1, -0.2, 0.3, -0.4]), np.array([1e5, 2e5, 3e5, 0.0])
FACTOR = np.exp(-3e-6 * (PRESSURE - 2e5))


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """A folder with the slot, an axis and its log."""
    monkeypatch.chdir(tmp_path)
    write_bench(tmp_path, count=1000)
    return tmp_path


@pytest.fixture
def oiled(bench):
    return load_slot_file("oiled.py")


def edited(*changes):
    """Return the slot of a file in which something is written otherwise."""
    text = SLOT
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    Path("edited.py").write_text(text)
    return load_slot_file("edited.py")


def test_a_saved_model_is_read_back_equal(oiled, bench):
    values = {"F_C_pos": 9.0, "F_C_neg": 8.0, "F_v_pos": 30.0, "F_v_neg": 31.0, "a": 2e-6}
    model = with_slots(coulomb_viscous, ["temperature", oiled, "asymmetry"])(**values, k_T=-0.01)
    (bench / "elsewhere").mkdir()
    write_model(bench / "elsewhere" / "model.toml", None, model)
    with pytest.raises(
        InputError, match=r"friction\.model: names code that needs permission to run: oiled\.py"
    ):
        read_model(bench / "elsewhere" / "model.toml")
    with pytest.warns(InputWarning, match=r"oiled\.py .* is run"):
        again = read_model(bench / "elsewhere" / "model.toml", allow_code=True).friction
    assert again == model == pickle.loads(pickle.dumps(model))
    assert (again.name, base_of(again.component), channel_slots_of(again.component)) == (
        "coulomb_viscous+temperature+oiled+asymmetry",
        coulomb_viscous,
        (oiled,),
    )
    assert model != model.with_values(a=3e-6)


def test_a_user_model_works_with_a_user_slot(oiled, bench):
    model = with_slots(br.load_code(DRAG), [oiled])(F_C=20.0, F_q=125.0, a=1e-6)
    write_model(bench / "both.toml", None, model)
    assert 'file = "quadratic_drag.py"\nslots = ["oiled.py"]\n' in Path("both.toml").read_text()
    with pytest.warns(InputWarning, match="is run"):
        assert read_model("both.toml", allow_code=True).friction == model


@pytest.mark.slow
def test_in_a_loop_the_channel_has_its_usual_value(bench):
    tables = {
        "schema": 1,
        "plant": {"M": "20 kg"},
        "run": {"duration": "0.5 s", "sample_time": "1 ms"},
        "controller": {"model": "cascade", "k_p": "80 1/s", "k_v": "4 N*s/mm"},
        "reference": {"model": "sine", "amplitude": "5 mm", "frequency": "2 Hz"},
        "compare": {"as_it_is": {}},
    }
    less = float(np.exp(-3e-6 * 1e5))
    custom = {"model": "coulomb_viscous+oiled.py", "F_C": 8.0, "F_v": 40.0, "a": 3e-6, "b_0": 1e5}
    Path("own.toml").write_text(tomlkit.dumps(tables | {"friction": custom}))
    with pytest.raises(
        InputError,
        match=r"oiled\.py .*needs permission to run|names code that needs permission to run: oiled",
    ):
        read_experiment("own.toml")
    with pytest.warns(InputWarning, match=r"oiled\.py .* is run"):
        experiment = read_experiment("own.toml", allow_code=True)
    scaled = {"model": "coulomb_viscous", "F_C": 8.0 * less, "F_v": 40.0 * less}
    Path("scaled.toml").write_text(tomlkit.dumps(tables | {"friction": scaled}))
    result, expected = (
        br.simulate(item).variants["as_it_is"].position
        for item in (experiment, read_experiment("scaled.toml"))
    )
    assert result == pytest.approx(expected, abs=1e-12)


@pytest.mark.slow
def test_the_force_is_that_of_the_equation(oiled):
    plain = force_along(find("coulomb_viscous")(F_C=8.0, F_v=30.0), V, DT)
    model = with_slots(coulomb_viscous, [oiled])(F_C=8.0, F_v=30.0, a=3e-6)
    assert force_along(model, V, DT, pressure=PRESSURE) == pytest.approx(FACTOR * plain)
    assert np.array_equal(force_along(model, V, DT), plain)
    assert np.array_equal(force_along(unvaried(model), V, DT, pressure=PRESSURE), plain)
    with pytest.raises(
        InputError, match=r"presure: is not a channel of coulomb_viscous.*Did you mean 'pressure'"
    ):
        force_along(model, V, DT, presure=PRESSURE)


@pytest.mark.slow
def test_before_sliding_the_limits_are_those_of_the_channel(oiled):
    model = with_slots(coulomb_viscous, [oiled])(F_C=8.0, F_v=0.0, a=3e-6)
    v = np.full(400, 1e-3)
    force = force_along(with_presliding(model, 1e-6), v, DT, pressure=3e5)
    assert force[-1] == pytest.approx(8.0 * np.exp(-0.3))
    turned = force_along(with_presliding(model, 1e-6), np.append(v, -1e-10), DT, pressure=3e5)[-1]
    assert turned == pytest.approx(force[-1], rel=1e-3)


def test_it_may_raise_the_level_alone(bench):
    level = edited(("example=", 'of="level", example='))
    model = with_slots(coulomb_viscous, [level])(F_C=8.0, F_v=30.0, a=3e-6)
    expected = 8.0 * FACTOR * np.sign(V) + 30.0 * V
    assert force_along(model, V, DT, pressure=PRESSURE) == pytest.approx(expected)


def test_a_user_slot_may_share_a_channel_of_bristle(oiled):
    warm = edited(
        (CHANNEL, '"temperature"'),
        ('"oiled"', '"warm"'),
        ("    a:", "    w:"),
        ("p.a ", "p.w "),
        ("b_0", "T_0"),
        ('{"a": 3e-6}', '{"w": 1e-2}'),
        ("2e5", "293.15"),
    )
    plain = force_along(find("coulomb_viscous")(F_C=8.0, F_v=30.0), V, DT)
    both = with_slots(coulomb_viscous, [warm, oiled])(F_C=8.0, F_v=30.0, a=3e-6, w=1e-2)
    assert [surrounding.name for surrounding in both.component.surroundings] == [
        "temperature",
        "pressure",
    ]
    with interpreted():
        force = force_along(both, V, DT, pressure=PRESSURE, temperature=303.15)
    assert force == pytest.approx(FACTOR * np.exp(-0.1) * plain)
    placed = edited((CHANNEL, '"position"'), ("2e5", "0.0"), ('"oiled"', '"placed"'))
    model, x = (
        with_slots(coulomb_viscous, [placed])(F_C=8.0, F_v=30.0, a=3.0),
        np.array([0.1, 0.2, 0.3, 0.4]),
    )
    with interpreted():
        text = force_along(model, V, DT, x)
    assert text == pytest.approx(np.exp(-3.0 * (x - 0.5 * DT * V)) * plain)


OTHER = [
    ("2e5)", "1e5)"),
    ('"oiled"', '"another"'),
    ("    a:", "    c:"),
    ("p.a ", "p.c "),
    ("b_0", "b_1"),
    ('{"a"', '{"c"'),
]


@pytest.mark.parametrize(
    ("slots", "words"),
    [
        (
            lambda oiled: [oiled, edited(*OTHER)],
            r"channel pressure: has different descriptions in two slots",
        ),
        (
            lambda oiled: [edited(("b_0", "F_C"))],
            r"F_C.*Give the parameter of the slot another name",
        ),
        (lambda oiled: [oiled, oiled], "a slot twice"),
    ],
)
def test_two_slots_must_agree_on_a_channel(oiled, slots, words):
    with pytest.raises(InputError, match=words):
        with_slots(lugre, slots(oiled))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "SLOT = Slot(",
            "SLUT = Slot(",
            r"defines no slot\. End the file with SLOT = Slot\(name=\.\.\., description",
        ),
        ("SLOT = Slot(", "SLOT = dict(", r"SLOT is not a Slot; found 'dict'"),
        ('name="oiled"', 'name="load"', r"an invalid name for its slot; found 'load'"),
        ('name="oiled"', 'name="a+b"', r"an invalid name for its slot; found 'a\+b'"),
        ("@kernel\n", "", r"factor: is not a kernel\. Decorate factor with @kernel"),
        (
            "factor(pressure, p)",
            "factor(pressure)",
            r"factor: takes 1 arguments; allowed factor\(channel, p\)",
        ),
        (
            'excitation="channel"',
            'excitation="speed"',
            r"excitation of a: is not an excitation for a slot; .* allowed \"channel\"",
        ),
        (
            ', excitation="channel"',
            "",
            r"has no parameter to identify from a log\. Write Variable\(.*\"channel\"",
        ),
        ('"force/length^2", "pressure of', '"presure", "pressure of', r"presure"),
        (
            'Surrounding("pressure"',
            'Surrounding("effort"',
            r"is already the name of a channel of bristle",
        ),
        (
            'Surrounding("pressure"',
            'Surrounding("my pressure"',
            r"is not a valid name of a channel",
        ),
        ("usual=2e5", "usual=-1.0", r"usual value of pressure: out of range"),
        (CHANNEL, '"humidity"', r"is not a channel of a log; found 'humidity'"),
        (
            "example=",
            'of="all", example=',
            r"argument `of` of oiled: is not a valid choice; found 'all'",
        ),
    ],
)
def test_an_invalid_file_is_refused_with_a_remedy(bench, old, new, said):
    with pytest.raises(InputError, match=rf"edited\.py.*{said}"):
        edited((old, new))


DRAG = Path(__file__).parents[2] / "examples" / "quadratic_drag.py"


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: load_slot_file(DRAG),
            r"defines a friction model. Write quadratic_drag\.py as the first name",
        ),
        (lambda: br.load_code("oiled.py"), r"oiled\.py: defines no friction model"),
        (lambda: find("lugre+oiled.py"), r"no such slot; found '\+oiled\.py'.*or a file of yours"),
    ],
)
def test_a_model_is_distinguished_from_a_slot(bench, call, words):
    with pytest.raises(InputError, match=words):
        call()


# --- the channel ------------------------------------------------------------------------------------------------


def test_a_further_channel_comes_in_si(bench):
    log = read_log("log.csv", read_axis("axis.toml"))
    assert list(log.surroundings) == ["pressure"]
    pressure = log.further["pressure"]
    assert pressure.values[:3] == pytest.approx(2e5 + 1e5 * np.sin(0.9e-3 * np.arange(3)), rel=1e-8)
    celsius = read_axis(AXIS.replace('unit = "bar"', 'unit = "degC"').encode())
    assert read_log("log.csv", celsius).further["pressure"].values[0] == pytest.approx(275.15)


@pytest.mark.parametrize(
    ("unit", "said"),
    [
        (
            "mm",
            r"pressure\.unit: has another quantity than the slot expects; found 'm', allowed pressure",
        ),
        (
            "-",
            r"columns\.pressure: has a median out of range.*found -2.*allowed >= 0 N/m\^2.*Check the unit of this column",
        ),
    ],
)
def test_a_channel_with_a_wrong_unit_or_a_sign_is_refused(bench, oiled, unit, said):
    new = 'unit = "bar", sign = -1' if unit == "-" else f'unit = "{unit}"'
    axis = read_axis(AXIS.replace('unit = "bar"', new).encode())
    with pytest.raises(InputError, match=said):
        br.identify(
            read_log("log.csv", axis), with_slots(coulomb_viscous, [oiled]), axis=axis, draws=0
        )


# --- export -----------------------------------------------------------------------------------------------------

AT = """#include "axis_x.h"
#include <stdio.h>
int main(void)
{
    static axis_x axis;
    axis_x_start(&axis);
    for (int i = 0; i < 60; ++i) {
        printf("%.17g\\n", axis_x_force_at(&axis, 1e-5 * ((i * 37) % 91), 5e-4, 300.0, 1e4 * i));
    }
    return 0;
}
"""


@pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
def test_in_c_the_channel_comes_in_and_the_bits_are_the_same(bench, oiled):
    from tests.exports.test_c import built

    component = with_slots(lugre, ["temperature", oiled, "asymmetry"])  # one around the other
    model = component(**component.example)
    br.export(model, "c", bench / "out")
    (bench / "out" / "at.c").write_text(AT)
    forces = np.array(built(bench / "out", "at.c").stdout.split(), dtype=float)
    x = 1e-5 * ((np.arange(60) * 37) % 91)
    with interpreted():
        expected = force_along(
            model,
            np.diff(x) / 5e-4,
            5e-4,
            x[1:],
            temperature=300.0,
            pressure=1e4 * np.arange(1.0, 60.0),
        )
    assert np.array_equal(forces[1:], expected)
