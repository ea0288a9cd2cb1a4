"""Laws of control in samples: what is fed forward, and the efforts of a simulated loop, bit for bit, in C and Structured Text."""

import ctypes
import math
import shutil
from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.exports.native import (
    COMPILER,
    RUN_LAW,
    built,
    differing,
    in_structured_text,
    library_of_laws,
    selected_cases,
)

import bristle as br
from bristle.apps.targets.fmu import source_text
from bristle.apps.targets.fmu_content import Setting, content_of_law
from bristle.apps.targets.hal import hal_law_files
from bristle.apps.targets.st import st_law_files
from bristle.contract import example_of
from bristle.core.experiment import Effort, Experiment, Feedforward, Learning, Run, Start, Variant
from bristle.exports.c import builds, law_files
from bristle.exports.described import Source
from bristle.exports.effect import effect_of_law
from bristle.exports.law import Inputs, law_facts, law_of, law_walk, settled_law, tunable_law
from bristle.exports.law_text import Gravity, Load, loads_of
from bristle.models.plants import inertia
from bristle.models.references import varied_sine
from bristle.models.sensors import encoder

pytestmark = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
DT, SAMPLES, M = 5e-4, 20_000, 631.65
STIFF = {"sigma_0": 36.066e6, "F_C": 42.725, "F_S": 50.265, "v_S": 397.89e-6}
LUGRE = br.friction.lugre(**STIFF, sigma_1=52430.0, sigma_2=4737.4)
CONTACT = br.friction.preisach_contact(kernel="reformed_dahl_exact", s=36.066e6, f_p=81.933)
LAWS = {
    "sliding_mode": br.controllers.sliding_mode(
        J=M, lambda_=150.0, K_1=150.0, K_2=5e-3, phi=2e-5, cutoff=400.0
    ),
    "cascade": br.controllers.cascade(k_p=40.0, k_v=8e4, k_i=2e6, k_ff=1.0, averaging=2),
    "observer": br.controllers.disturbance_observer(
        J=M, lambda_=150.0, K_1=150.0, g=60.0, cutoff=400.0
    ),
    "twisting": br.controllers.super_twisting(
        J=M,
        lambda_=150.0,
        K_1=150.0,
        k_1=1e-2,
        k_2=1.0,
        estimator="tracking_observer",
        cutoff=200.0,
    ),
    "bristles": br.controllers.lugre_observer(
        J=M,
        lambda_=150.0,
        K_1=150.0,
        F_C=42.7,
        F_S=50.3,
        v_S=4e-4,
        sigma_0=18e6,
        sigma_2=4737.4,
        k=1.0,
        cutoff=400.0,
    ),
    "learning": br.controllers.adaptive_hysteresis(
        J=M,
        lambda_=150.0,
        K_1=150.0,
        reach=7e-6,
        Gamma=8e5,
        w_max=60.0,
        delta=2e-5,
        cutoff=400.0,
        w_0=3.0,
        w_2=8.0,
        w_6=5.0,
    ),
    "observed": br.controllers.asymptotic_observer(
        J=M,
        lambda_=150.0,
        K_1=150.0,
        g_1=60.0,
        g_2=600.0,
        F_C=42.7,
        sigma_0=18e6,
        K_I=20.0,
        band=2e-7,
        cutoff=400.0,
    ),
    "reversing": br.controllers.predictive_reversal(
        J=M,
        lambda_=150.0,
        K_1=150.0,
        F_C=42.7,
        F_S=50.3,
        v_S=4e-4,
        F_v=4737.0,
        lead=2e-3,
        x_0=2e-6,
        cutoff=400.0,
    ),
}
# What is fed forward enters them as it does the others'
SECOND = ("bristles", "learning", "observed", "reversing")
assert {law.name for law in LAWS.values()} == set(br.controllers.CONTROLLERS)
PAPER = Feedforward(friction=CONTACT, gain=0.64, offset=3.1416, asymmetry=0.15)
RISEN = br.friction.find("lugre+transmitted")(**STIFF, sigma_1=52430.0, sigma_2=4737.4, c_T=0.4)
TOOTHED = {
    "M": M,
    "g_sin": 3e5,
    "g_cos": 4.0,
    "motor_turn": 5e-6,
    **dict.fromkeys(("motor_1_cos", "motor_1_sin"), 3.0),
}
TOOTHED_PLANT = br.plants.find("inertia+gravity+cogging", TOOTHED)(**TOOTHED)
SPRUNG = br.plants.find("inertia+spring", ["spring_3"])(
    M=M, spring_1=2e6, spring_2=1e11, spring_3=-1e16
)
LINK = br.plants.find("inertia+gravity", ["g_cos"])(M=2.0 * M, g_sin=3e5, g_cos=4.0)
FED = {
    "nothing": (Feedforward(), 1, 30.0),
    "desired": (PAPER, 1, np.inf),
    "measured": (replace(PAPER, along="measured", rate_limit=2e4), 0, np.inf),
    "all": (Feedforward(friction=LUGRE, mass=M, limit=45.0, conditioning=2e-6), 3, 80.0),
}
CARRYING = {
    "link": (Feedforward(friction=RISEN, carries=LINK), 2, np.inf),
    "toothed": (
        Feedforward(mass=M, plant=TOOTHED_PLANT, friction=RISEN, carries=TOOTHED_PLANT),
        1,
        np.inf,
    ),
    "sprung": (Feedforward(mass=M, plant=SPRUNG, friction=RISEN, carries=SPRUNG), 1, np.inf),
    "toothed_measured": (
        Feedforward(plant=TOOTHED_PLANT, friction=RISEN, carries=LINK, along="measured"),
        2,
        90.0,
    ),
}


def variant_of(controller, fed, name="loop"):
    feedforward, delay, limit = (FED | CARRYING)[fed]
    return Variant(
        name,
        inertia(M=M),
        LUGRE,
        LAWS[controller],
        encoder(resolution=1.25e-7, noise=2e-7, seed=3),
        varied_sine(frequency=0.25, duration=10.0, amplitudes=[6.8e-6, 5.0e-6, 3.4e-6, 6.8e-6]),
        feedforward,
        Run(duration=SAMPLES * DT, sample_time=DT, delay=delay, effort_limit=limit, substeps=4),
    )


# First each way to be fed, and what other tests here need of them.
FIRST = [
    ("cascade", "measured"),
    ("cascade", "toothed"),
    ("sliding_mode", "desired"),
    ("observer", "all"),
    ("twisting", "nothing"),
]
CASES = [
    (controller, fed)
    for controller in LAWS
    for fed in (("desired",) if controller in SECOND else FED)
]
CASES += [("cascade", fed) for fed in CARRYING]
CASES = [*FIRST, *(case for case in CASES if case not in FIRST)]


def compiled_cases(request):
    """Return the cases that tests ask for."""
    cases = (
        selected_cases(request, "controller", "fed")
        | {("cascade", fed) for (fed,) in selected_cases(request, "fed")}
        | {*FIRST}
    )
    return [case for case in CASES if case in cases]


@cache
def law(controller, fed):
    return law_of(variant_of(controller, fed))


@pytest.fixture(scope="module")
def exported(request, tmp_path_factory):
    """The laws in one library, with the folder that they are in."""
    folder = tmp_path_factory.mktemp("laws")
    texts = {
        f"{controller}_{fed}": law_files(law(controller, fed), f"{controller}_{fed}", Source())
        for controller, fed in compiled_cases(request)
    }
    return folder, library_of_laws(
        folder, texts, {name: RUN_LAW.format(name=name) for name in texts}
    )


def told(law, x, v, a, measured):
    """Return the inputs of a law in rows, for all samples that have a complete window ahead."""
    message = {"position": x, "velocity": v, "acceleration": a, "measured": measured}
    for name, signal in (("place_ahead", x), ("acceleration_ahead", a)):
        message[name] = np.lib.stride_tricks.sliding_window_view(signal[1:], law.samples_ahead)
    used = min(len(message["place_ahead"]), len(measured))
    return np.column_stack([message[name][:used] for name in law.inputs])


def recorded(variant):
    """Return what the law was told at each sample but the last ones, whose next ones there are not, and its efforts."""
    outcome = br.simulate(Experiment("one", variant.plant.kind, (variant,))).variants[variant.name]
    t = variant.run.sample_time * np.arange(outcome.time.size + variant.run.delay)
    inputs = told(
        law_of(variant),
        *variant.reference.component.sample(t, variant.reference.parameters),
        outcome.measured,
    )
    return inputs, outcome.command[: len(inputs)]


@cache
def record_of(controller, fed):
    return recorded(variant_of(controller, fed))


def replayed(library, name, inputs, *further):
    pointer, efforts = ctypes.POINTER(ctypes.c_double), np.empty(len(inputs))
    inputs = np.ascontiguousarray(inputs, dtype=float)
    run = getattr(library, f"run_{name}")
    run.restype = None
    run(inputs.ctypes.data_as(pointer), len(inputs), efforts.ctypes.data_as(pointer), *further)
    return efforts


@pytest.mark.fast_cases(len(FIRST))
@pytest.mark.parametrize(("controller", "fed"), CASES)
def test_a_log_is_replayed_exactly(exported, controller, fed):
    inputs, efforts = record_of(controller, fed)
    assert len(efforts) == SAMPLES - 1
    assert np.ptp(efforts) > 20.0
    assert inputs[0, 0] != inputs[0, 3]  # it begins where it is measured, not where it should be
    assert differing(replayed(exported[1], f"{controller}_{fed}", inputs), efforts) == 0


@pytest.fixture(scope="module")
def blocks(request, tmp_path_factory):
    texts = {}
    for controller, fed in compiled_cases(request):
        name = f"law_{controller}_{fed}"
        files = st_law_files(law(controller, fed), name, Source())
        texts[name] = [files[f"{name}{end}.st"] for end in ("", "_selftest")]
    return in_structured_text(texts, tmp_path_factory.mktemp("blocks"))


@pytest.mark.slow
@pytest.mark.parametrize(("controller", "fed"), CASES)
def test_structured_text_replays_a_log_exactly(blocks, controller, fed):
    name, (inputs, efforts) = f"law_{controller}_{fed}", record_of(controller, fed)
    result, flags = blocks.replay(name, inputs)
    assert differing(result, efforts) == 0
    assert not flags.any()
    assert blocks.selftest(name) == (True, True)


@pytest.mark.slow
def test_structured_text_includes_the_past_of_a_compensator(tmp_path):
    law = law_of(
        replace(variant_of("cascade", "desired"), feedforward=replace(PAPER, conditioning=2e-6))
    )
    assert np.any(law.memory)
    files = st_law_files(law, "led", Source())
    block = in_structured_text({"led": [files["led.st"], files["led_selftest.st"]]}, tmp_path)
    assert block.selftest("led") == (True, True)


@pytest.mark.slow
def test_structured_text_repeats_the_last_effort(blocks):
    inputs, efforts = record_of("cascade", "all")
    inputs, efforts = inputs[:6].copy(), efforts[:6]
    inputs[2, 3], inputs[4, -1] = np.nan, np.inf
    result, flags = blocks.replay("law_cascade_all", inputs, commands=[0, 0, 0, 2, 0, 1])
    assert result[[0, 1, 2]].tolist() == [*efforts[:2], efforts[1]]
    assert result[4] == result[3]
    assert flags.tolist() == [0, 0, 1, 0, 1, 0]
    alone, _ = blocks.replay("law_cascade_all", inputs[5:])
    assert result[5] == alone[0]


@pytest.mark.slow
@pytest.mark.parametrize("fed", FED | CARRYING)
def test_the_self_test_passes_and_the_example_runs(exported, fed):
    folder, name = exported[0] / f"cascade_{fed}", f"cascade_{fed}"
    watching = ("-fsanitize=undefined",) if builds(COMPILER, "-fsanitize=undefined") else ()
    ran = built(folder, f"{name}_selftest.c", *watching, name=name)
    assert ran.returncode == 0, ran.stdout
    assert "identical to bristle" in ran.stdout
    assert ran.stderr == ""
    assert built(folder, "example_main.c", name=name).returncode == 0


def test_a_sample_that_is_not_a_number_is_skipped_and_the_effort_repeated(exported):
    inputs, _ = record_of("sliding_mode", "desired")
    inputs = inputs[:50]
    wrong = inputs[20].copy()
    for column in range(inputs.shape[1]):
        for value in (np.nan, np.inf):
            wrong[:] = inputs[20]
            wrong[column] = value
            efforts = replayed(
                exported[1], "sliding_mode_desired", np.insert(inputs, 20, wrong, axis=0)
            )
            expected = replayed(exported[1], "sliding_mode_desired", inputs)
            assert differing(efforts, np.insert(expected, 20, expected[19])) == 0


def test_each_start_resets_the_law(exported):
    inputs, efforts = record_of("observer", "all")
    for _ in range(2):
        assert differing(replayed(exported[1], "observer_all", inputs[:200]), efforts[:200]) == 0


@pytest.mark.slow
def test_a_variant_is_exported_from_python(tmp_path):
    variant = variant_of("sliding_mode", "all")
    with pytest.raises(br.core.InputError, match=r"makes the error larger.*accept-harm"):
        br.export(variant, "c", tmp_path / "law", name="slide")
    result = br.export(variant, "c", tmp_path / "law", name="slide", accept_harm=True)
    assert result.files[:3] == ("slide.h", "slide.c", "slide_selftest.c")
    assert any("4 samples" in note for note in result.notes)
    header = (tmp_path / "law" / "slide.h").read_text()
    assert "double place_ahead[4];" in header
    assert "limit      80 " in header  # the controller knows that of its drive
    assert all(len(line) <= 130 for line in header.splitlines())


def test_the_start_of_a_simulated_loop_does_not_change_its_law(tmp_path):
    variant = variant_of("cascade", "nothing")
    for name, start in (("rest", None), ("moves", Start(position=1e-6, velocity=1e-3))):
        br.export(replace(variant, start=start), "c", tmp_path / name, name="law")
    assert (tmp_path / "rest" / "law.c").read_text() == (tmp_path / "moves" / "law.c").read_text()


# --- parameters that may be changed, and single precision -------------------------------------------------------------

# For each law what is changed, by the name of its field, and the loop with these values.
CHANGED = {
    ("cascade", "toothed"): (
        {"feedforward_mass": 600.0, "friction_F_S": 55.0, "friction_c_T": 0.3},
        {"friction": {"F_S": 55.0, "c_T": 0.3}, "feedforward": {"mass": 600.0}},
    ),
    ("cascade", "measured"): (
        {
            "controller_k_v": 7e4,
            "friction_f_p": 75.0,
            "feedforward_gain": 0.9,
            "feedforward_asymmetry": 0.05,
        },
        {
            "controller": {"k_v": 7e4},
            "friction": {"f_p": 75.0},
            "feedforward": {"gain": 0.9, "asymmetry": 0.05},
        },
    ),
    ("sliding_mode", "desired"): (
        {"controller_lambda_": 140.0, "controller_cutoff": 300.0, "feedforward_offset": 1.0},
        {"controller": {"lambda_": 140.0, "cutoff": 300.0}, "feedforward": {"offset": 1.0}},
    ),
}
RUN_CHANGED = """
#include "{name}.h"
void run_{name}(const {name}_inputs *inputs, int count, double *effort, int changed)
{{
    static {name} axis;
    {name}_start(&axis);
    if (changed) {{
        {lines}
    }}
    for (int i = 0; i < count; ++i) {{
        effort[i] = {name}_effort(&axis, &inputs[i]);
    }}
}}
"""


def changed_variant(tuned):
    variant, (_, values) = variant_of(*tuned), CHANGED[tuned]
    feedforward = replace(variant.feedforward, **values["feedforward"])
    friction = feedforward.friction.with_values(**values.get("friction", {}))
    law = variant.controller.with_values(**values.get("controller", {}))
    return replace(variant, controller=law, feedforward=replace(feedforward, friction=friction))


@pytest.fixture(scope="module")
def otherwise(request, tmp_path_factory):
    """Laws with parameters that may be changed, in double and in single precision: C as a library, and blocks."""
    folder, files, callers, blocks = tmp_path_factory.mktemp("otherwise"), {}, {}, {}
    for controller, fed in {("cascade", "toothed")} | {
        tuned for (tuned,) in selected_cases(request, "tuned")
    }:
        for single in (False, True):
            name = f"{controller}_{fed}_{'single' if single else 'double'}"
            law = law_of(variant_of(controller, fed), tunable=True, single=single)
            files[name], written = law_files(law, name, Source()), st_law_files(law, name, Source())
            end = "f" if single else ""
            lines = [
                f"axis.parameters.{field} = {value!r}{end};"
                for field, value in CHANGED[controller, fed][0].items()
            ]
            callers[name] = RUN_CHANGED.format(name=name, lines=" ".join(lines))
            blocks[name] = [written[f"{name}{part}.st"] for part in ("", "_selftest")]
    return folder, library_of_laws(folder, files, callers), blocks


@pytest.mark.slow
@pytest.mark.parametrize("tuned", CHANGED, ids="_".join)
def test_exported_parameters_give_the_exact_efforts_of_the_loop(otherwise, tuned):
    inputs, efforts = record_of(*tuned)
    assert differing(replayed(otherwise[1], f"{'_'.join(tuned)}_double", inputs, 0), efforts) == 0


@pytest.mark.slow
@pytest.mark.parametrize("tuned", CHANGED, ids="_".join)
def test_a_changed_parameter_gives_the_exact_efforts_of_the_changed_loop(otherwise, tuned):
    inputs, efforts = recorded(changed_variant(tuned))
    result = replayed(otherwise[1], f"{'_'.join(tuned)}_double", inputs, 1)
    assert differing(result, efforts) == 0
    assert (
        differing(result, replayed(otherwise[1], f"{'_'.join(tuned)}_double", inputs, 0))
        > SAMPLES // 2
    )


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("tuned", CHANGED, ids="_".join)
def test_the_deviation_of_single_precision_stays_within_the_stated_bound(otherwise, tuned):
    inputs, efforts = record_of(*tuned)
    result = replayed(otherwise[1], f"{'_'.join(tuned)}_single", inputs, 0)
    off = np.max(np.abs(result - efforts)) / np.max(np.abs(efforts))
    assert 0.0 < off < 2.5e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "said"), [("double", "identical to bristle"), ("single", "within single precision")]
)
def test_both_pass_their_self_tests(otherwise, kind, said):
    name = f"cascade_toothed_{kind}"
    watching = ("-fsanitize=undefined",) if builds(COMPILER, "-fsanitize=undefined") else ()
    ran = built(otherwise[0] / name, f"{name}_selftest.c", *watching, name=name)
    assert ran.returncode == 0, ran.stdout
    assert said in ran.stdout
    assert ran.stderr == ""
    assert built(otherwise[0] / name, "example_main.c", name=name).returncode == 0


def test_the_single_precision_self_test_detects_a_wrong_gain(otherwise, tmp_path):
    name = "cascade_toothed_single"
    folder = tmp_path / name
    shutil.copytree(otherwise[0] / name, folder)
    text = (folder / f"{name}.c").read_text()
    wrong = text.replace(
        "axis->parameters.controller_k_v = 80000.0f;", "axis->parameters.controller_k_v = 80500.0f;"
    )
    assert wrong != text
    (folder / f"{name}.c").write_text(wrong)
    ran = built(folder, f"{name}_selftest.c", name=name)
    assert (ran.returncode, "exceeds the error of single precision" in ran.stdout) == (1, True)


@pytest.fixture(scope="module")
def tuned_blocks(otherwise, tmp_path_factory):
    return in_structured_text(otherwise[2], tmp_path_factory.mktemp("tuned"))


def told_to(blocks, name, law, inputs, further):
    """Return a row for each call of a block: its inputs, and its parameters, of which some are changed."""
    values = {
        parameter.lower().strip("_"): value for parameter, _, value in tunable_law(law).numbers()
    }
    further = {key.lower().strip("_"): value for key, value in further.items()}
    assert set(further) <= set(values)
    values |= further
    keys = blocks.inputs[name][len(law.inputs) :]
    assert set(keys) == set(values)
    parameters = np.array([min(values[key], 1e37) for key in keys])
    return np.hstack([inputs, np.tile(parameters, (len(inputs), 1))])


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("tuned", CHANGED, ids="_".join)
def test_structured_text_is_identical_to_c(otherwise, tuned_blocks, tuned, precision):
    name, law = f"{'_'.join(tuned)}_{precision}", law_of(variant_of(*tuned), tunable=True)
    inputs, _ = record_of(*tuned)
    for changed in (0, 1):
        further = CHANGED[tuned][0] if changed else {}
        result, flags = tuned_blocks.replay(name, told_to(tuned_blocks, name, law, inputs, further))
        assert differing(result, replayed(otherwise[1], name, inputs, changed)) == 0
        assert not flags.any()
    assert tuned_blocks.selftest(name) == (True, True)


@pytest.mark.parametrize("to", ["c", "st"])
@pytest.mark.parametrize("tunable", [False, True])
@pytest.mark.parametrize(
    ("given", "path"),
    [({"mass": 1e39}, "mass"), ({"friction": LUGRE.with_values(sigma_0=1e39)}, "sigma_0")],
)
def test_feedforward_beyond_single_precision_is_refused(tmp_path, to, tunable, given, path):
    variant = variant_of("cascade", "all")
    beyond = replace(variant, feedforward=replace(variant.feedforward, **given))
    with pytest.raises(br.core.InputError, match=rf"{path}: is too large for single precision"):
        br.export(beyond, to, tmp_path / "out", float32=True, tunable=tunable, accept_harm=True)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_note_states_the_state_that_parameters_do_not_change(tmp_path):
    variant = variant_of("cascade", "desired")
    led = replace(variant, feedforward=replace(PAPER, conditioning=2e-6))
    notes = br.export(led, "c", tmp_path / "led", tunable=True, float32=True).notes
    assert any("computed with the exported parameters" in note for note in notes)
    assert any("single precision" in note and "effort" in note for note in notes)
    fixed = br.export(led, "c", tmp_path / "fixed").notes
    assert not any(
        "computed with the exported parameters" in note or "single precision" in note
        for note in fixed
    )


def test_a_user_controller_starts_by_a_kernel(tmp_path):
    cascade = LAWS["cascade"].component

    def start(measured, velocity, acceleration, dt, p):
        return cascade.start(measured, velocity, acceleration, dt, p)

    custom = replace(LAWS["cascade"], component=replace(cascade, start=start))
    with pytest.raises(br.core.InputError, match="is not a kernel"):
        br.export(
            replace(variant_of("cascade", "nothing"), controller=custom), "c", tmp_path / "law"
        )


TICK, LEAD, J, TABLE_MASS = 1e-3, 10e-3, 5e-4, 150.0
ARM = LEAD / (2.0 * math.pi)
SCREW = br.plants.ball_screw(
    kind="rotational", J=J, M=TABLE_MASS, lead=LEAD, k=3e6, d=1500.0, backlash=20e-6
)
MOTOR = br.friction.coulomb(kind="rotational", F_C=0.05)
SLIPS = br.friction.maxwell_slip(kind="rotational", F_C=0.05, k_i=[60.0, 30.0], nu_i=[0.5, 0.5])
DRY = br.friction.coulomb(F_C=200.0)
RUBS = br.friction.maxwell_slip(F_C=200.0, k_i=[6e7, 3e7], nu_i=[0.5, 0.5])
CASCADE = br.controllers.cascade(kind="rotational", k_p=15.0, k_v=60.0 * J, k_i=900.0 * J, k_ff=1.0)
SLIDING = br.controllers.sliding_mode(
    kind="rotational", J=J + TABLE_MASS * ARM**2, lambda_=50.0, K_1=50.0
)
BOTH = Feedforward(plant=SCREW, friction=MOTOR, table=DRY)
# Controller, feedforward, delay, and side of the sensor.
SCREWED = {
    "both": (CASCADE, BOTH, 1, "motor"),
    "memories": (
        SLIDING,
        replace(BOTH, friction=SLIPS, table=RUBS, conditioning=1e-3, gain=0.9, asymmetry=0.1),
        3,
        "motor",
    ),
    "measured": (SLIDING, replace(BOTH, along="measured", wind_up_time=0.02), 2, "motor"),
    "scale": (SLIDING, Feedforward(plant=SCREW, friction=MOTOR), 0, "load"),
    "table": (CASCADE, Feedforward(plant=SCREW, table=DRY, wind_up_time=1e-3), 0, "motor"),
}


def screwed_variant(case):
    controller, feedforward, delay, side = SCREWED[case]
    reference = br.references.sine(kind="rotational", amplitude=12.0, frequency=0.5)
    sensor = br.sensors.encoder(kind="rotational", resolution=1e-5)
    run = Run(2.0, TICK, delay=delay, substeps=4, effort_limit=20.0)
    return Variant(
        "base",
        SCREW,
        MOTOR,
        controller,
        sensor,
        reference,
        feedforward,
        run,
        table=DRY,
        sensor_at=side,
    )


@cache
def screwed_law(case):
    return law_of(screwed_variant(case))


@cache
def screwed_record(case):
    """Return the inputs of a law during its simulated loop, and the simulated efforts."""
    return recorded(screwed_variant(case))


def laws_in_c(folder, laws, calls=RUN_LAW):
    texts = {name: law_files(each, name, Source()) for name, each in laws.items()}
    return library_of_laws(folder, texts, {name: calls.format(name=name) for name in laws})


@pytest.fixture(scope="module")
def screwed(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("laws")
    return folder, laws_in_c(
        folder, {case: screwed_law(case) for (case,) in selected_cases(request, "case")}
    )


@pytest.mark.fast_cases(3)
@pytest.mark.parametrize("case", SCREWED)
def test_the_efforts_are_those_of_the_simulation(screwed, case):
    inputs, efforts = screwed_record(case)
    assert len(inputs) > 1800
    assert np.ptp(efforts) > 0.5
    assert differing(replayed(screwed[1], case, inputs), efforts) == 0


# --- other targets and options ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", ["memories", pytest.param("measured", marks=pytest.mark.slow)])
def test_the_self_test_in_c_passes(screwed, case):
    ran = built(screwed[0] / case, f"{case}_selftest.c", name=case)
    assert (ran.returncode, "identical to bristle" in ran.stdout) == (0, True)


@pytest.mark.parametrize("case", ["memories", pytest.param("both", marks=pytest.mark.slow)])
def test_structured_text_gives_the_efforts_of_the_simulation(tmp_path, case):
    files = st_law_files(screwed_law(case), "led", Source())
    block = in_structured_text({"led": [files["led.st"], files["led_selftest.st"]]}, tmp_path)
    inputs, efforts = screwed_record(case)
    result, flags = block.replay("led", inputs)
    assert differing(result, efforts) == 0
    assert not flags.any()
    assert block.selftest("led") == (True, True)


def test_the_step_of_an_fmu_holds_all_memories_apart():
    each = screwed_law("memories")
    content = content_of_law(each, "led", Source())
    text = source_text(content, Setting("led", Source(), TICK, 2))[0]
    assert "now->memory, now->memory + 2, now->memory + 4, " in text
    assert (
        content.memory.size
        == each.memory_size
        == sum(memory.size for memory in each.memories.values())
    )
    assert content.memory.tolist()[:4] == [
        *each.memories["memory"].tolist(),
        *each.memories["table_memory"].tolist(),
    ]


def test_the_header_states_numbers_that_come_from_the_motion():
    each = screwed_law("measured")
    lines = law_facts(each, "axis_x", Source())["fed"]
    assert "the wind-up is a mean over 10 samples (10 ms) before and after each sample" in lines
    clear = each.p.screw.clear
    assert f"the motor changes the flank of the screw at a force beyond {clear:.4g} N" in lines
    assert each.samples_ahead == 2 + 10 + 4
    assert screwed_law("table").samples_ahead == 4
    head = law_files(each, "axis_x", Source())["axis_x.h"]
    assert all(len(line) <= 130 for line in head.splitlines())
    assert "double table_effort; /* friction fed forward [N] */" in head


def test_parameters_of_both_sides_can_change():
    tuned = tunable_law(law_of(screwed_variant("both"), tunable=True))
    assert [tuned.values[name] for name in ("table_F_C", "friction_F_C", "feedforward_M")] == [
        200.0,
        0.05,
        150.0,
    ]
    units = {name: variable.unit("rotational") for name, variable in tuned.variables.items()}
    assert (units["friction_F_C"], units["table_F_C"], units["feedforward_M"]) == ("N*m", "N", "kg")
    assert (units["feedforward_k"], units["feedforward_arm"], units["feedforward_clear"]) == (
        "N/m",
        "m/rad",
        "N",
    )


@pytest.mark.slow
def test_single_precision_stays_close(tmp_path):
    single = law_of(screwed_variant("both"), single=True, tunable=True)
    inputs, efforts = screwed_record("both")
    result = replayed(laws_in_c(tmp_path, {"law_single": single}), "law_single", inputs)
    off = np.max(np.abs(result - efforts)) / np.max(np.abs(efforts))
    assert 0.0 < off < 1e-3


def test_a_component_of_hal_with_too_many_pins_is_refused():
    with pytest.raises(br.core.InputError, match=r"hal: has too many inputs.*20 pins"):
        hal_law_files(screwed_law("both"), "led", Source())
    few = hal_law_files(screwed_law("table"), "led", Source()).files
    assert "pin in float acceleration_ahead_3" in few["led.comp"]


def test_the_effect_of_a_law_compares_the_error_of_the_table():
    effect = effect_of_law(screwed_law("measured").variant)
    lost = 2.0 * (200.0 / 3e6 + 10e-6) / ARM  # the table reverses the screw
    assert effect.reach == pytest.approx(lost)
    own = br.simulate(
        Experiment("loops", "rotational", (screwed_law("measured").variant,))
    ).variants["base"]
    assert effect.along[-1].with_it == pytest.approx(own.true_error.peak_to_peak, rel=0.1)
    assert effect.along[-1].with_it != pytest.approx(own.following_error.peak_to_peak, rel=0.1)
    assert all(path.ratio < 0.5 for path in effect.along)


# --- one law ---------------------------------------------------------------------------------------------------------


MASS, MILLISECOND = 2.0, 1e-3
COULOMB = br.friction.with_slots(br.friction.coulomb, [])(F_C=5.0, offset=0.5)
TRANSMITTED = br.friction.find("coulomb+transmitted")(F_C=5.0, c_T=0.2)
PENDULUM = br.plants.find("inertia+gravity")(M=3.0, g_sin=4.0, g_cos=1.0)
BRISTLES = br.friction.lugre(F_C=5.0, F_S=6.0, v_S=1e-2, sigma_0=1e5)


def variant(feedforward=None, delay=0, limit=math.inf, **changes):
    parts = {
        "name": "loop",
        "plant": br.plants.inertia(M=MASS),
        "friction": COULOMB,
        "controller": br.controllers.cascade(k_p=20.0, k_v=30.0),
        "sensor": br.sensors.encoder(resolution=0.0),
        "reference": br.references.recorded(position=np.zeros(100), sample_time=MILLISECOND),
        "feedforward": feedforward or Feedforward(),
        "run": Run(0.1, MILLISECOND, delay=delay, effort_limit=limit),
    }
    return Variant(**parts | changes)


def fed(reported, delay=0, **feedforward):
    """Return the inputs of a law, and what its feedforward adds at each sample."""
    law, plain = (law_of(variant(each, delay=delay)) for each in (Feedforward(**feedforward), None))
    return law.inputs, law.efforts(reported) - plain.efforts(reported)


def at_rest(ahead, a=0.0, a_ahead=0.0, measured=0.0):
    """A sample at 0, with the positions and accelerations of the next ones."""
    return Inputs(0.0, 0.0, a, measured, np.array(ahead), np.full(len(ahead), a_ahead))


def test_a_law_may_be_named_law():
    names = [function.name for function in law_of(variant()).unit.functions]
    assert "law_command_kernel" in names
    assert not {"law", "law_inputs", "law_start", "law_effort", "law_command"} & set(names)


def test_inertia_is_fed_forward_as_the_mean_of_two_samples():
    inputs, efforts = fed([at_rest([0.0], a, a + 1.0) for a in (0.0, 1.0, 2.0)], mass=MASS)
    assert inputs == ("position", "velocity", "acceleration", "measured", "acceleration_ahead")
    assert efforts == pytest.approx([1.0, 3.0, 5.0])


@pytest.mark.parametrize("delay", [0, 2])
def test_friction_along_the_desired_motion_leads_by_the_delay(delay):
    x = np.array([0.0, 0.0, 0.0, 0.0, 1e-4, 2e-4, 1e-4, 0.0, -1e-4, -2e-4])
    _, efforts = fed([at_rest(x[k + 1 : k + 2 + delay]) for k in range(6)], delay, friction=COULOMB)
    ways = np.sign(np.diff(x))[delay : delay + 6]
    assert efforts[ways != 0.0] == pytest.approx(5.0 * ways[ways != 0.0] + 0.5)


def test_friction_along_the_measured_motion_needs_no_samples_ahead():
    reported = [at_rest(np.zeros(3), measured=x) for x in (0.0, 1e-4, 2e-4, 1e-4)]
    inputs, efforts = fed(reported, 2, friction=COULOMB, along="measured")
    assert inputs == ("position", "velocity", "acceleration", "measured")
    assert efforts[1:] == pytest.approx([5.5, 5.5, -4.5])


@pytest.mark.parametrize(
    ("way", "shape", "force"),
    [
        (1.0, {}, 5.5),
        (1.0, {"gain": 0.5}, 2.75),
        (1.0, {"gain": 0.5, "offset": 1.0}, 3.75),
        (1.0, {"limit": 3.0}, 3.0),
        (-1.0, {"limit": 3.0}, -3.0),
        (1.0, {"asymmetry": 0.2}, 5.5 * 1.2),
        (-1.0, {"asymmetry": 0.2}, -4.5 * 0.8),
    ],
)
def test_gain_asymmetry_and_limit_shape_the_feedforward(way, shape, force):
    x = way * 1e-4 * np.arange(7)
    reported = [Inputs(x[k], way * 0.1, 0.0, x[k], x[k + 1 : k + 2], np.zeros(1)) for k in range(5)]
    assert fed(reported, friction=COULOMB, **shape)[1][-1] == pytest.approx(force)


def test_a_drive_limits_the_effort():
    far = [Inputs(1.0, 0.0, 0.0, 0.0, np.ones(1), np.zeros(1))] * 3
    assert law_of(variant(limit=7.0)).efforts(far) == pytest.approx([7.0] * 3)
    assert law_of(variant()).efforts(far)[-1] > 100.0


def test_gravity_acts_at_the_middle_of_two_samples():
    load, carried = loads_of(Feedforward(plant=PENDULUM))
    assert load is carried
    assert (load.place, load.numbers) == (Gravity(4.0, 1.0), (0.0, 4.0, 1.0))
    _, gravity = fed([Inputs(0.2, 0.0, 0.0, 0.2, np.array([0.4]), np.zeros(1))], plant=PENDULUM)
    assert gravity == pytest.approx([4.0 * math.sin(0.3) + math.cos(0.3)])


def test_friction_transmits_the_feedforward_or_the_carried_plant():
    fed, carried = loads_of(Feedforward(mass=MASS, friction=TRANSMITTED, carries=PENDULUM))
    assert (fed.prefix, fed.mass, carried.prefix, carried.mass) == ("", MASS, "carried_", 3.0)
    with pytest.raises(
        br.core.InputError, match="has forces besides inertia, gravity, cogging and a spring"
    ):
        loads_of(Feedforward(friction=TRANSMITTED, carries=example_of(br.plants.oscillator)))
    assert Load("", 0.0, None).text("", "0") == "0.0"


SAME = br.plants.inertia(M=MASS)


@pytest.mark.parametrize(
    ("feedforward", "apart", "prefix"),
    [
        ({"mass": MASS, "friction": TRANSMITTED}, False, ""),
        ({"mass": MASS, "friction": TRANSMITTED, "carries": SAME}, False, ""),
        ({"mass": MASS, "friction": TRANSMITTED, "carries": SAME}, True, "carried_"),
        ({"mass": MASS, "friction": COULOMB, "carries": PENDULUM}, False, ""),
    ],
)
def test_a_carried_plant_is_that_of_the_feedforward_if_they_are_equal(feedforward, apart, prefix):
    fed, carried = loads_of(Feedforward(**feedforward), apart=apart)
    assert carried.prefix == prefix
    assert (carried is fed) == (prefix == "")


def test_a_compensator_with_a_past_starts_with_the_memory_of_a_sweep():
    fresh, worn = (
        law_of(variant(Feedforward(friction=BRISTLES, conditioning=size))) for size in (0.0, 1e-3)
    )
    assert float(fresh.lasting.fed.state.z) == 0.0
    assert worn.lasting.fed.state == br.engine.conditioned(BRISTLES, 1e-3)[0]


def test_leaves_are_all_numbers_of_the_state_in_order():
    law = law_of(variant(Feedforward(friction=BRISTLES)))
    paths = [".".join(path) for path, _ in law.leaves]
    assert paths[-4:] == ["fed.state.z", "fed.place", "fed.share", "fed.effort"]
    assert all(path.startswith(("controller.", "fed.")) for path in paths)
    assert law.memory_size == law.memory.size
    assert law.dt == MILLISECOND


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"effort": Effort(np.zeros(100))}, "drives an open loop"),
        ({"learning": Learning(2, 1.0, 0.0, 20.0)}, "needs repetitions of the whole motion"),
    ],
)
def test_variants_without_a_law_are_refused(changes, words):
    with pytest.raises(br.core.InputError, match=words):
        law_of(variant(**changes))


def test_facts_of_a_law_list_feedforward_and_samples_ahead():
    facts = law_facts(
        law_of(variant(Feedforward(mass=MASS, friction=COULOMB, gain=0.5), delay=2, limit=9.0)),
        "axis_x",
        Source(),
    )
    assert facts["fed"] == [
        "inertia along the desired motion: 2 kg",
        "friction along the desired motion by coulomb, gain 0.5",
    ]
    assert (facts["ahead"], facts["delay"], facts["limit"], facts["rate"]) == (3, 2, "9", "1000")
    assert [(entry["declared"], entry["unit"], entry["several"]) for entry in facts["inputs"]] == [
        ("position", "m", False),
        ("velocity", "m/s", False),
        ("acceleration", "m/s^2", False),
        ("measured", "m", False),
        ("place_ahead[3]", "m", True),
        ("acceleration_ahead[3]", "m/s^2", True),
    ]


@pytest.mark.parametrize(
    ("feedforward", "first", "last"),
    [
        ({}, "nothing", "nothing"),
        (
            {"friction": TRANSMITTED, "plant": PENDULUM, "carries": PENDULUM},
            "position-dependent effort of inertia+gravity",
            "that inertia+gravity transmits along the desired motion",
        ),
        (
            {"mass": MASS, "friction": TRANSMITTED},
            "inertia",
            "that the rest of the feedforward transmits along the desired motion",
        ),
    ],
)
def test_facts_of_a_law_state_what_is_transmitted(feedforward, first, last):
    lines = law_facts(law_of(variant(Feedforward(**feedforward))), "axis_x", Source())["fed"]
    assert lines[0].startswith(first)
    assert lines[-1].endswith(last)


def test_the_self_test_measures_each_position_one_sample_late():
    law = law_of(variant(Feedforward(mass=MASS, friction=COULOMB)))
    walk, reported, efforts = law_walk(law, 40)
    assert reported == 40 + law.samples_ahead + 1
    assert efforts.shape == (40,)
    x = walk.positions(reported)
    v = np.diff(x) / MILLISECOND
    first = Inputs(x[0], v[0], 100.0 * v[0], x[0], x[1:2], 100.0 * v[1:2])
    second = Inputs(x[1], v[1], 100.0 * v[1], x[0], x[2:3], 100.0 * v[2:3])
    assert law.efforts([first, second]) == pytest.approx(efforts[:2])


LAW, TUNABLE = (
    law_of(variant(Feedforward(mass=2.0)), tunable=tunable) for tunable in (False, True)
)


def length(text) -> int:
    return sum(map(len, text.values())) if isinstance(text, Mapping) else len(text)


@pytest.mark.parametrize("write", [law_files, st_law_files], ids=["c", "st"])
def test_folding_earlier_or_later_gives_the_same_law(write):
    assert write(LAW, "axis_x", Source()) == write(settled_law(LAW), "axis_x", Source())


@pytest.mark.parametrize("write", [law_files, st_law_files], ids=["c", "st"])
def test_a_law_with_variable_parameters_is_longer(write):
    assert length(write(TUNABLE, "axis_x", Source())) > length(write(LAW, "axis_x", Source()))


def test_folding_earlier_or_later_gives_the_same_fmu_of_a_law():
    texts = [
        printed(content_of_law(law, "axis_x", Source()).unit)
        for law in (TUNABLE, settled_law(TUNABLE))
    ]
    assert texts[0] == texts[1]


def printed(unit) -> str:
    """Every function of a unit, as its tree has it."""
    return "\n".join(
        repr((function.name, function.parameters, function.body)) for function in unit.functions
    )
