"""LinuxCNC: the text of a component and its HAL files, the component compiled in place of HAL, and HAL itself."""

import re
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from tests.apps.targets.linuxcnc import DECLARED, LACKING, PERIOD, Component, in_hal, text_of
from tests.exports.importing import needs_compiler
from tests.exports.native import ALL, COMPILER, differing, example_with
from tests.exports.test_laws import CASES, variant_of

import bristle as br
from bristle.apps.targets import hal
from bristle.cli.main import main
from bristle.engine.contact import steady_force
from bristle.exports.described import Request, Source
from bristle.exports.law import law_of
from bristle.files.axis import axis_from
from bristle.models.controllers.feedforward import Rule
from bristle.models.plants.terms import effort_of_place, terms_of, with_terms

LUGRE = br.friction.find("lugre")(
    F_C=8.0, F_S=11.0, v_S=4e-3, sigma_0=1e6, sigma_2=80.0, offset=3.0
)
COGS = with_terms(br.plants.inertia, cogging={"motor": [6]})(
    M=20.0, motor_turn=5e-3, motor_6_cos=1.0, motor_6_sin=2.0
)
AXIS = {
    "schema": 1,
    "kind": "translational",
    "columns": {
        "position": {"column": "q", "unit": "mm"},
        "effort": {"column": "u", "unit": "A", "sign": -1},
    },
    "effort": {"force_constant": "50 N/A", "limit": "400 N"},
    "timing": {"sample_time": "1 ms"},
}


def request_of(model=LUGRE, **options):
    return Request(model, "axis_x", 1e-3, **({"rest": "held", "speed": 0.2} | options))


def written(model=LUGRE, **options):
    return hal.write(request_of(model, **options)).files


def played(files):
    """Return references and expected feeds of the self-test."""
    lines = text_of(files, "_selftest.txt").splitlines()
    return np.array([[float(word) for word in line.split()] for line in lines]).T


AT_ONCE = {"gain": 1.0, "slew": 1e9}


@pytest.fixture(scope="module")
def component(tmp_path_factory):
    """The component of a model with cogging."""
    if COMPILER is None:
        pytest.skip("no C compiler")
    return Component(written(plant=COGS), tmp_path_factory.mktemp("component"))


def moving(count=600, reach=2.0):
    """Return positions of a cycle with reversals [mm]."""
    return reach * np.sin(2.0 * np.pi * np.arange(count) / 400.0)


# --- names and text -----------------------------------------------------------------------------------------------


def test_pins_and_parameters_are_documented_and_begin_without_force():
    declared = {
        name: (way, value) for way, _, name, value in DECLARED.findall(text_of(written(), ".comp"))
    }
    assert set(declared) == set(hal.PINS)
    assert [name for name, (way, _) in declared.items() if way == "pin out"] == [
        "feed",
        "gain_now",
        "fault",
    ]
    assert [name for name, (way, _) in declared.items() if way == "pin in"] == [
        "reference",
        "gain",
        "reset",
    ]
    assert declared["gain"][1] == "0"
    assert declared["clock"][1] == "1"


HASHED = Source({"model": "model.toml", "model_sha256": "80d7ae7f" + 56 * "0"})


@pytest.mark.parametrize(
    ("options", "end", "words"),
    [
        # The component has the name of the hash of the model file.
        ({}, ".comp", "component bristle_80d7ae7f "),
        ({}, ".hal", "loadrt bristle_80d7ae7f\n"),
        ({}, ".hal", "net x-pos-cmd => bristle-80d7ae7f.reference"),
        # The machine file names both entries and the mode.
        ({}, ".hal", "=> pid.x.bias\n"),
        ({}, ".hal", "TORQUE MODE only"),
        ({}, ".hal", "loadrt sum2 "),
        ({}, ".hal", "before the function that writes the output"),
        # Signs are those of the log.
        ({"axis": axis_from(AXIS)}, ".hal", ".effort-scale -50.0\n"),
        ({"axis": axis_from(AXIS)}, "_selftest.hal", ".effort-scale -50.0\n"),
        ({}, "_table.hal", "loadrt lincurve count=1 personality=16"),
        ({}, "_table.hal", "the memory of the model is lost"),
    ],
)
def test_files_are_named_after_the_model_and_say_how_they_are_loaded(options, end, words):
    text = written(source=HASHED, **options)[f"bristle_80d7ae7f{end}"]
    assert words in text or words in text.replace("\n# ", " ")


def test_another_name_is_that_of_the_component():
    assert "knee.comp" in hal.write(replace(request_of(), name="knee")).files
    with pytest.raises(
        br.core.InputError, match=r"name: is too long for a HAL component.*34 characters"
    ):
        hal.write(replace(request_of(), name="a" * 35))


def test_units_and_limit_are_those_of_the_log():
    declared = {
        name: value
        for _, _, name, value in DECLARED.findall(text_of(written(axis=axis_from(AXIS)), ".comp"))
    }
    assert (
        float(declared["scale"]),
        float(declared["effort_scale"]),
        float(declared["limit"]),
    ) == (1e-3, -50.0, 8.0)
    turning = br.friction.lugre(kind="rotational", F_C=0.034, F_S=0.04, v_S=0.5, sigma_0=100.0)
    assert "1 deg" in hal.write(request_of(turning, speed=5.0)).notes[1]


@pytest.mark.parametrize(
    ("delay", "lead"),
    [(-2.7e-3, 2.7e-3), (0.0, 0.0), (1e-3, 0.0), (-0.3, hal.LEAD_MAX), (None, 1e-3)],
)
def test_the_lead_is_that_of_the_identification_or_one_cycle(delay, lead):
    assert hal.settings_of(
        request_of(
            axis=axis_from(AXIS), info={"treatment": {} if delay is None else {"delay": delay}}
        )
    ).lead == pytest.approx(lead)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--to hal --hal-mode velocity", "velocity command"),
        ("--to c --hal-mode torque", "--hal-mode: applies to --to hal only"),
        ("--to hal --hal-mode torque", ""),
    ],
)
def test_velocity_mode_is_refused_by_name(tmp_path, capsys, options, words):
    (tmp_path / "model.toml").write_text(
        'schema = 1\nkind = "translational"\n[friction]\nmodel = "coulomb"\nF_C = "8 N"\n',
        encoding="utf-8",
    )
    code = main(
        ["export", str(tmp_path / "model.toml"), "--out", str(tmp_path / "out"), *options.split()]
    )
    assert code == (2 if words else 0)
    assert words in capsys.readouterr().err
    assert len(list(tmp_path.glob("out/bristle_????????.comp"))) == (not words)


def test_the_machine_file_begins_at_gain_0():
    text = written(source=HASHED)["bristle_80d7ae7f.hal"]
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    assert [line.split()[0] for line in lines] == ["loadrt", *["setp"] * 5, "addf", "net", "net"]
    assert any(line.endswith(".gain 0") for line in lines)


def test_the_table_for_lincurve_has_its_points_and_its_error():
    text = text_of(written(plant=COGS), "_table.hal")
    rows = re.findall(r"^setp lincurve\.0\.([xy])-val-(\d\d) (\S+)$", text, re.MULTILINE)
    x, y = (
        np.array([float(value) for axis, _, value in rows if axis == wanted]) for wanted in "xy"
    )
    assert x.size == y.size == 16
    assert np.all(np.diff(x) > 0.0)
    stated = float(
        re.search(
            r"steady friction of the model by at most ([\d.e-]+) N", text.replace("\n# ", " ")
        )[1]
    )
    speeds = np.linspace(0.5, 200.0, 300)  # mm/s
    for v in (speeds, -speeds):
        error = np.abs(np.interp(v, x, y) - [steady_force(LUGRE, 1e-3 * each) for each in v])
        assert error.max() <= 1.1 * stated
    unknown = hal.write(request_of(speed=0.0))
    assert not any("table" in name for name in unknown.files)
    assert unknown.notes[-1].endswith("the largest speed is unknown: no table")


# --- the component compiled in place of HAL -----------------------------------------------------------------------


@needs_compiler
@pytest.mark.parametrize(
    "name",
    ["lugre", "stribeck", "maxwell_slip", pytest.param("preisach_lugre", marks=pytest.mark.slow)],
)
def test_the_component_gives_the_bits_of_the_self_test(tmp_path, name):
    files = written(
        example_with(name, ("asymmetry",)),
        plant=COGS,
        axis=axis_from(AXIS),
        rule=Rule(0.9, 1e-5, 0.05, 3.0, 40.0),
    )
    references, expected = played(files)
    assert references.size >= 200
    fed = Component(files, tmp_path).feed(references, **AT_ONCE, limit=0.0)
    assert np.ptp(expected) > 0.0
    assert differing(fed, expected) == 0


def test_the_expected_lines_are_those_of_halsampler():
    files = written()
    references, expected = played(files)
    lines = text_of(files, "_selftest_expected.txt").splitlines()
    assert lines[7] == f"{references[7]:.6f} {expected[7]:.6f} 0.000000 "
    assert len(lines) == references.size


def test_the_feed_is_friction_constant_force_and_cogging_at_the_reference(component):
    mm = moving()
    fed = component.fresh().feed(mm, **AT_ONCE, lead=0.0)
    friction = br.response(LUGRE, 1e-3 * mm, 1e-3)
    assert friction[200:].mean() == pytest.approx(3.0, abs=0.5)  # the constant force
    assert fed[1:] == pytest.approx(
        (friction + effort_of_place(1e-3 * mm, terms_of(COGS)))[1:], rel=1e-9
    )


@needs_compiler
def test_the_feed_contains_a_spring(tmp_path_factory):
    plant = with_terms(br.plants.inertia, spring="cubic")(
        M=20.0, spring_1=300.0, spring_2=2e4, spring_3=-1e6
    )
    component, mm = Component(written(plant=plant), tmp_path_factory.mktemp("sprung")), moving()
    friction = br.response(LUGRE, 1e-3 * mm, 1e-3)
    spring = 0.3 * mm + 0.02 * mm**2 - 1e-3 * mm**3
    assert component.feed(mm, **AT_ONCE, lead=0.0)[1:] == pytest.approx(
        (friction + spring)[1:], rel=1e-9
    )


def test_the_lead_takes_the_feed_of_a_later_cycle(component):
    mm = moving()
    later = component.fresh().feed(mm, **AT_ONCE, lead=0.0)[3:]
    led = component.fresh().feed(mm, **AT_ONCE, lead=3e-3)[:-3]
    late = component.fresh().feed(mm, **AT_ONCE, lead=0.0)[:-3]
    assert np.std((led - later)[20:]) < 0.05 * np.std((late - later)[20:])
    assert (
        differing(
            *(component.fresh().feed(mm, **AT_ONCE, lead=lead) for lead in (hal.LEAD_MAX, 1.0))
        )
        == 0
    )
    assert (
        differing(
            component.fresh().feed(mm, **AT_ONCE, lead=-1.0),
            component.fresh().feed(mm, **AT_ONCE, lead=0.0),
        )
        == 0
    )


def test_the_gain_begins_at_0_and_follows_at_slew(component):
    one = component.fresh()
    assert not one.feed(moving()).any()
    one.feed(moving(100), gain=1.0, slew=2.0)
    assert one.pins.gain_now == pytest.approx(0.2)
    one.feed(moving(1000), gain=5.0)
    assert one.pins.gain_now == 1.0
    one.feed(moving(100), gain=float("nan"))
    assert one.pins.gain_now == pytest.approx(0.8)


def test_the_feed_stays_within_the_limit_and_scales_with_units_and_clock(component):
    mm = moving()
    whole = component.fresh().feed(mm, **AT_ONCE, lead=0.0)
    assert np.abs(component.fresh().feed(mm, **AT_ONCE, lead=0.0, limit=2.0)) == pytest.approx(
        np.minimum(np.abs(whole), 2.0)
    )
    assert component.fresh().feed(
        1e-3 * mm, **AT_ONCE, lead=0.0, scale=1.0, effort_scale=-50.0
    ) == pytest.approx(-whole / 50.0, rel=1e-6)
    assert component.fresh().feed(
        mm, PERIOD // 10, **AT_ONCE, lead=0.0, clock=10.0
    ) == pytest.approx(whole, rel=1e-9)


def test_an_invalid_reference_sets_fault_and_takes_the_feed_away_until_reset(component):
    one = component.fresh()
    one.feed(moving(200), gain=1.0, slew=100.0)
    fed = one.feed([0.1, float("nan"), 0.1, 0.1], slew=250.0)
    assert one.pins.fault
    assert np.all(np.isfinite(fed))
    assert one.pins.gain_now == pytest.approx(0.25)
    one.feed(moving(50))
    assert one.pins.gain_now == 0.0
    one.feed([0.1], reset=1)
    assert not one.pins.fault
    one.feed(moving(100), reset=0)
    assert one.pins.gain_now == 1.0


# --- control laws -------------------------------------------------------------------------------------------------


def law_files_of(controller, fed):
    return hal.hal_law_files(law_of(variant_of(controller, fed)), "bristle_law", Source())


@needs_compiler
@pytest.mark.parametrize(
    ("controller", "fed"),
    [("cascade", "all"), pytest.param("sliding_mode", "desired", marks=pytest.mark.slow)],
)
def test_a_law_gives_the_bits_of_its_self_test(tmp_path, controller, fed):
    product = law_files_of(controller, fed)
    *columns, expected = played(product.files)
    law, one = np.column_stack(columns), Component(product.files, tmp_path)
    assert (
        differing(one.feed(law, PERIOD // 2, enable=1, scale=1.0, effort_scale=1.0), expected) == 0
    )
    assert product.notes == (
        "run the component in a thread of 0.5 ms, the sample time of the experiment",
    )
    # Before it is enabled, and after a fault, it commands nothing; enable begins anew.
    assert not one.feed(law[:9], PERIOD // 2, enable=0).any()
    assert differing(one.feed(law[:9], PERIOD // 2, enable=1), expected[:9]) == 0
    assert one.feed(np.full_like(law[:2], np.nan), PERIOD // 2).tolist() == [0.0, 0.0]
    assert not one.feed(law[:9], PERIOD // 2).any()
    one.feed(law[:1], PERIOD // 2, enable=0)
    assert one.feed(law[:9], PERIOD // 2, enable=1).any()
    assert not one.feed(law[:9], PERIOD).any()  # the thread has another period
    assert one.pins.fault


def test_units_of_a_law_are_those_of_the_log_or_mm():
    text = law_files_of("cascade", "desired").files["bristle_law.comp"]
    assert "scale = 0.001 " in text
    assert 'pin in float place_ahead_1 "' in text


@needs_compiler
def test_no_operation_is_fused(tmp_path):
    machine = subprocess.run(
        [COMPILER, "-dumpmachine"], capture_output=True, text=True, check=True
    ).stdout
    if not machine.startswith("x86_64"):
        pytest.skip("asks for the instructions of x86-64")
    files = written(plant=COGS)
    for text, fused in (
        (files, False),
        ({n: t.replace('"fp-contract=off"', '"O2"') for n, t in files.items()}, True),
    ):
        Component(text, tmp_path, more=["-mfma", "-ffp-contract=fast", "-save-temps"])
        assembly = next(tmp_path.glob("*component.s")).read_text(encoding="ascii")
        assert (re.search(r"\bvfn?m(add|sub)", assembly) is not None) == fused


# --- HAL ----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.skipif(bool(LACKING), reason=LACKING)
@pytest.mark.parametrize("slots", [(), ALL], ids=["plain", "varied"])
@pytest.mark.parametrize("name", br.friction.MODELS)
def test_hal_computes_identical_feeds(tmp_path, name, slots):
    files = written(example_with(name, slots), plant=COGS, speed=0.0)
    component_name = next(file for file in files if file.endswith(".comp")).removesuffix(".comp")
    measured = in_hal(files, tmp_path, f"{component_name}_selftest.hal")[
        f"{component_name}_selftest_measured.txt"
    ]
    assert [line for line in measured.splitlines() if line != "overrun"] == text_of(
        files, "_selftest_expected.txt"
    ).splitlines()


@pytest.mark.slow
@pytest.mark.skipif(bool(LACKING), reason=LACKING)
@pytest.mark.parametrize(("controller", "fed"), CASES)
def test_hal_computes_identical_efforts_of_a_law(tmp_path, controller, fed):
    files = law_files_of(controller, fed).files
    measured = in_hal(files, tmp_path, "bristle_law_selftest.hal")[
        "bristle_law_selftest_measured.txt"
    ]
    assert [line for line in measured.splitlines() if line != "overrun"] == text_of(
        files, "_selftest_expected.txt"
    ).splitlines()


@pytest.mark.slow
@pytest.mark.skipif(bool(LACKING), reason=LACKING)
def test_the_self_test_in_hal_notices_a_changed_bit(tmp_path):
    files = hal.write(replace(request_of(), name="bristle_test")).files
    number = repr(float(LUGRE.values["F_C"]))
    assert files["bristle_test.comp"].count(number) >= 1
    files["bristle_test.comp"] = files["bristle_test.comp"].replace(
        number, repr(np.nextafter(float(number), 9.0).item())
    )
    measured = in_hal(files, tmp_path, "bristle_test_selftest.hal")[
        "bristle_test_selftest_measured.txt"
    ]
    assert measured.splitlines()[-1] != files["bristle_test_selftest_expected.txt"].splitlines()[-1]


@pytest.mark.slow
@pytest.mark.skipif(bool(LACKING), reason=LACKING)
def test_the_lines_for_a_machine_and_the_table_load(tmp_path):
    files = hal.write(replace(request_of(), name="bristle_test")).files
    machine = (
        "loadrt threads name1=servo-thread period1=1000000\nloadrt pid names=pid.x\naddf pid.x.do-pid-calcs servo-thread\n"
        "newsig x-pos-cmd float\nsource bristle_test.hal\nnewsig x-vel-cmd float\nsource bristle_test_table.hal\nstart\n"
        "sets x-vel-cmd 1000\nloadusr -w sleep 0.1\ngetp lincurve.0.out\nshow thread\nshow pin pid.x.bias\n"
    )
    said = in_hal(files | {"machine.hal": machine}, tmp_path, "machine.hal")["stdout"]
    assert re.findall(r"^ +\d (\S+)$", said, re.MULTILINE) == [
        "lincurve.0",
        "bristle-test",
        "pid.x.do-pid-calcs",
    ]
    assert float(said.split()[0]) == pytest.approx(steady_force(LUGRE, 0.2), rel=1e-3)
    assert "pid.x.bias <== x-friction" in said
