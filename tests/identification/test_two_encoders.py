"""Two masses from encoders at motor and load or a sensor between them; the simulated drives share no code with the identification."""

import math
import re
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from benchmarks.elastic import with_sensor
from benchmarks.two_mass import drive_of, log_of, of_the_motor
from tests.identification.known_logs import STATED
from tests.identification.rigid import identify

import bristle as br
from bristle.core import InputError
from bristle.core.diagnostic import Diagnostic
from bristle.engine.motion import along
from bristle.engine.screwed import through_screw
from bristle.files import read_axis, read_experiment, results_folder
from bristle.identification.lost_motion import Hysteresis, LostMotion, lost_motion, stretched
from bristle.identification.quantities import Quantity
from bristle.identification.side_logs import (
    alone,
    behind_sensor,
    effort_delay,
    side_logs,
    without_sensor,
)
from bristle.identification.two_encoders import Masses, Prior, Record, masses_of
from bristle.identification.two_masses import TwoMasses, _doubt, apart, two_masses, with_two_masses
from bristle.prediction import steady_curve
from bristle.report.brief import brief
from bristle.report.compensation import closing_sentences, gain_of
from bristle.report.figures.two_masses import (
    force_of_both_sides,
    friction_of_both_sides,
    lost_motion as lost_motion_figure,
    shows_lost_motion,
)
from bristle.report.two_masses import (
    EXPERIMENT_FILE,
    elastic_cards,
    models_of,
    title_of,
    two_masses_lines,
    two_masses_table,
    write_two_masses,
)
from bristle.simulation import simulate

DT = 1e-3  # s


@pytest.fixture(scope="module", autouse=True)
def simulator():
    """The simulator of the drives is compiled, and the drive of several tests is simulated."""
    records_of(904)
    records_of(904, nut=0.15)
    with_hysteresis(911, 0.2)


def with_hysteresis(seed, share):
    """A drive, the distance after which an element of its coupling slips, and its log with this element."""
    drive, ((motor, load, *_),) = records_of(seed)
    distance = 0.15 * float(np.ptp(np.quantile(motor - load, [0.005, 0.995])))
    return drive, distance, log_of(replace(drive, hysteresis=(share, distance)))


def records_of(seed, seconds=None, nut=0.0):
    drive = replace(drive_of(seed), nut=nut)
    count = None if seconds is None else round(seconds / drive.sample_time)
    motor, load, effort = (
        log_of(drive)[name][:count] for name in ("position", "load_position", "effort")
    )
    return drive, [Record(motor, load, effort, drive.sample_time)]


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("seed", [904, 901, 920])
def test_masses_stiffness_and_delay_are_those_of_the_drive(seed):
    drive, records = records_of(seed)
    masses = masses_of(records, drive.step)
    assert masses.values[:2] == pytest.approx([drive.motor, drive.load], rel=0.02)
    assert masses.stiffness == pytest.approx(drive.stiffness, rel=0.02)
    assert (
        abs(masses.stiffness / drive.stiffness - 1.0)
        < 4.0 * masses.stiffness_error / masses.stiffness + 0.004
    )
    # The recorded effort is a mean over a sample, which ends half a sample later.
    assert masses.delay == pytest.approx(
        (drive.late - 0.5) * drive.sample_time, abs=0.1 * drive.sample_time
    )


def test_a_log_without_strokes_shows_no_masses():
    draw = np.random.default_rng(3)
    still = 1e-6 * np.round(draw.normal(size=5000))
    assert masses_of([Record(still, still, draw.normal(size=5000), DT)], 1e-6) is None


def with_true_values(drive):
    """The true masses as if they had been identified."""
    values = np.zeros(9)
    values[:4] = (
        drive.motor,
        drive.load,
        drive.load / drive.stiffness,
        2.0 * drive.damping / (2.0 * np.pi * drive.antiresonance),
    )
    values[6] = (drive.late - 0.5) * drive.sample_time
    return Masses(values, np.zeros(9), drive.stiffness, 0.0)


@pytest.mark.slow
@pytest.mark.fast_cases(2)
@pytest.mark.parametrize("seed", [910, 920, 916, 925])
def test_play_is_told_from_friction_that_winds_up_the_drive(seed):
    drive, records = records_of(seed)
    lost = lost_motion(records, drive.step, with_true_values(drive))
    assert lost.clear == (drive.gap > 0.0)
    assert lost.stiffness == pytest.approx(drive.stiffness, rel=0.03)
    if drive.gap:
        assert abs(lost.play - drive.gap) < 4.0 * lost.play_error + 0.01 * drive.gap
        assert lost.dead(np.array([lost.centre, lost.centre + drive.gap])) == pytest.approx(
            [0.0, drive.gap - 0.5 * lost.play]
        )


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("seed", "nut", "seconds"),
    [
        (905, 0.15, 20.0),
        (904, 0.15, None),
        (904, 0.0, None),
        (905, 0.15, None),
        (911, 0.15, None),
        (911, 0.0, None),
    ],
)
def test_friction_of_a_nut_grows_with_the_force_of_the_coupling(seed, nut, seconds):
    drive, records = records_of(seed, seconds, nut=nut)
    lost = lost_motion(records, drive.step, with_true_values(drive))
    assert lost.nut_is_clear == (nut > 0.0)
    assert abs(lost.nut - nut) < 4.0 * lost.nut_error
    assert lost.stiffness == pytest.approx(drive.stiffness, rel=0.03)
    assert lost.clear == (drive.gap > 0.0)  # a nut is not taken for play
    share = lost.nut_share(records[0])
    assert np.ptp(share) == pytest.approx(2.0 * lost.nut if nut else 0.0, rel=0.01)


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("seed", "share", "seconds"),
    [(911, 0.2, 8.0), (911, 0.2, None), (911, 0.0, None), (905, 0.2, None), (905, 0.0, None)],
)
def test_hysteresis_of_the_coupling_has_the_width_and_the_stiffness_of_its_element(
    seed, share, seconds
):
    drive, distance, log = with_hysteresis(seed, share)
    count = None if seconds is None else round(seconds / drive.sample_time)
    record = Record(
        *(log[name][:count] for name in ("position", "load_position", "effort")), drive.sample_time
    )
    loop = lost_motion([record], drive.step, with_true_values(drive)).hysteresis
    assert (loop is not None) == (share > 0.0)
    if loop is not None:
        assert abs(loop.width - 2.0 * share * drive.stiffness * distance) < 4.0 * loop.error
        assert loop.large == pytest.approx(drive.stiffness, rel=0.03)
        assert loop.small == pytest.approx((1.0 + share) * drive.stiffness, rel=0.03)
        amplitude = 0.5 * (
            float(np.ptp(np.quantile(record.motor - record.load, [0.005, 0.995]))) - drive.gap
        )
        # Three elements share the distance.
        assert loop.loss == pytest.approx(2.0 * loop.width * (amplitude - distance), rel=0.15)


@pytest.mark.slow
def test_friction_of_an_unknown_nut_is_taken_for_a_larger_load():
    drive, records = records_of(904, nut=0.15)
    assert masses_of(records, drive.step).values[1] > 1.04 * drive.load


@pytest.mark.slow
def test_friction_of_a_known_nut_is_not_taken_for_a_larger_load():
    drive, records = records_of(904, 40.0, nut=0.15)
    known = masses_of(records, drive.step, prior=Prior(nut=0.15, nut_error=0.02))
    assert known.values[:2] == pytest.approx([drive.motor, drive.load], rel=0.02)
    assert known.stiffness == pytest.approx(drive.stiffness, rel=0.02)
    # The error of the nut is that of the load.
    assert 0.005 * drive.load < known.errors[1] < 0.02 * drive.load


@pytest.mark.slow
def test_a_rotary_axis_has_the_masses_and_the_play_of_the_linear_axis_that_it_drives():
    drive, records = records_of(916)
    turns = 40.0  # rad/m
    rotary = [
        Record(turns * record.motor, turns * record.load, record.effort / turns, record.dt)
        for record in records
    ]
    pairs = (records, drive.step, "translational"), (rotary, turns * drive.step, "rotational")
    linear, turned = (masses_of(every, step) for every, step, _ in pairs)
    assert turned.values[:2] * turns**2 == pytest.approx(linear.values[:2], rel=1e-3)
    play, angle = (
        lost_motion(every, step, fit, kind)
        for (every, step, kind), fit in zip(pairs, (linear, turned), strict=True)
    )
    assert angle.clear
    assert angle.play / turns == pytest.approx(play.play, abs=2.0 * play.play_error)
    assert angle.stiffness * turns**2 == pytest.approx(play.stiffness, rel=0.01)


def test_a_load_encoder_with_another_unit_is_refused():
    log = br.Log.from_columns(strokes(load_position=lambda position: 1e3 * position))
    with pytest.raises(
        InputError,
        match=r"columns\.load_position: moves otherwise than the motor; found '1e\+03 times as far'",
    ):
        two_masses([(log, None)], identify)


def effort_along(position, time):
    speed = np.gradient(position, time)
    return 12.0 * np.gradient(speed, time) + 5.0 * np.sign(speed) + 80.0 * speed


def strokes(**further):
    time = DT * np.arange(6000)
    position = 0.02 * np.sin(3.0 * time) + 0.01 * np.sin(11.0 * time)
    return {
        "time": time,
        "position": position,
        "effort": effort_along(position, time),
        **{name: values(position) for name, values in further.items()},
    }


def test_the_result_for_one_mass_does_not_depend_on_the_second_encoder(masses):
    plain, second = (
        masses.motor,
        identify(strokes(load_position=np.copy), "stribeck", draws=0, blocks=0),
    )
    assert plain.two_masses is None
    assert second.best.friction.values == plain.best.friction.values
    assert second.treatment == plain.treatment
    # Both positions are equal: the log shows no coupling, and the result states why.
    assert second.two_masses is None
    assert "the plant with two masses" in second.left_out


@pytest.mark.parametrize(
    ("load", "cause"),
    [
        (lambda x: 1.001 * x, r"The scale moves 1\.001 times as far as the motor"),
        (
            lambda x: x + 1e-3 * np.linspace(0.0, 1.0, x.size),
            r"The encoders drift apart by 0\.001 ",
        ),
        (
            lambda x: np.concatenate([x[:1].repeat(2), x[:-2]]),
            r"like a delay of 2 ms between the encoders",
        ),
        (
            lambda x: x + 1e-5 * np.random.default_rng(2).normal(size=x.size),
            r"Excite the axis around its antiresonance",
        ),
    ],
)
def test_a_faulty_scale_is_named_as_the_reason(load, cause):
    time = DT * np.arange(8000)
    position = np.convolve(
        np.pad(0.1 * np.abs((0.7 * time) % 2.0 - 1.0), 50, mode="edge"),
        np.full(101, 1.0 / 101.0),
        "valid",
    )
    columns = {
        "time": time,
        "position": position,
        "effort": effort_along(position, time),
        "load_position": load(position),
    }
    reason = two_masses([(br.Log.from_columns(columns), None)], identify)
    assert re.search(cause, reason)


def swapped(log):
    return {"position": log["load_position"], "load_position": log["position"]}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "changes", "cause"),
    [
        *((seed, swapped, "`position` is the encoder of the motor") for seed in (901, 920)),
        *(
            (seed, lambda log: {"effort": -log["effort"]}, "the sign of the effort")
            for seed in (901, 920)
        ),
        (
            901,
            lambda log: {
                "load_position": np.append(
                    log["load_position"][:1].repeat(3), log["load_position"][:-3]
                )
            },
            "at the same time",
        ),
    ],
)
def test_swapped_encoders_a_reversed_effort_and_a_late_scale_do_not_make_a_plant(
    seed, changes, cause
):
    drive = drive_of(seed)
    log = {name: log_of(drive)[name] for name in ("time", "position", "load_position", "effort")}
    pairs = [(br.Log.from_columns(log | changes(log)), br.Axis(resolution=drive.step))]
    assert cause in two_masses(pairs, partial(identify, model="coulomb_viscous", draws=0))


@pytest.mark.parametrize("channel", ["load_position", "coupling_effort"])
def test_only_logs_that_all_have_a_second_encoder_or_a_sensor_have_two_masses(channel):
    with_load, without = (
        br.Log.from_columns(strokes(**further)) for further in ({channel: lambda x: x}, {})
    )
    alone, pairs = apart([(with_load, None), (with_load, None)])
    assert [log.further for log, _ in alone] == [{}, {}]
    assert len(pairs) == 2
    assert apart([(with_load, None), (without, None)])[1] == ()


@pytest.fixture(scope="module")
def masses():
    side = identify(strokes(), "stribeck", draws=0, blocks=0)
    values = {
        "motor": 2.0,
        "load": 10.0,
        "stiffness": 4e6,
        "damping": 300.0,
        "play": 5e-6,
        "antiresonance": 100.0,
        "nut": 0.15,
    }
    quantities = tuple(
        Quantity(name, value, 0.02 * value, "kg", name) for name, value in values.items()
    )
    return TwoMasses(quantities, side, side, 0.0, arm=0.01 / (2.0 * math.pi))


def with_quantity(masses, name, **changes):
    return replace(
        masses,
        quantities=tuple(
            item._replace(**changes) if item.name == name else item for item in masses.quantities
        ),
    )


def test_friction_of_the_motor_has_the_power_of_that_of_the_axis(masses):
    speed = np.array([0.002, 0.05, -0.01, -0.2])
    of_axis, of_motor = masses.motor.best.friction, masses.motor_friction
    assert of_motor.kind == "rotational"
    assert along(of_motor, speed / masses.arm, DT) * speed / masses.arm == pytest.approx(
        along(of_axis, speed, DT) * speed
    )


def test_a_break_away_level_that_the_log_does_not_show_is_that_of_sliding(masses):
    best = masses.load.best
    high = best.friction.with_values(F_S=5.0 * best.friction.values["F_C"])
    for status, level in (
        ("at_edge", best.friction.values["F_C"]),
        ("identified", high.values["F_S"]),
    ):
        estimates = tuple(
            replace(item, status=status) if item.name == "F_S" else item for item in best.estimates
        )
        side = replace(masses.load, fits=(replace(best, friction=high, estimates=estimates),))
        assert replace(masses, load=side).table_friction.values["F_S"] == level


def test_the_plant_has_the_energy_of_both_masses_and_of_the_coupling(masses):
    plant = masses.plant
    assert plant.values["lead"] == pytest.approx(0.01)
    assert 0.5 * plant.values["J"] * (0.3 / masses.arm) ** 2 == pytest.approx(0.5 * 2.0 * 0.3**2)
    assert (plant.values["M"], plant.values["k"], plant.values["backlash"]) == (10.0, 4e6, 5e-6)


def test_report_and_terminal_state_masses_and_friction_of_either_side(masses):
    identification = SimpleNamespace(two_masses=masses)
    rows = [tuple(map(str, row[:2])) for row in two_masses_table(identification).rows]
    assert {("", "Motor"), ("", "Load"), ("", "Stiffness"), ("", "Play")} <= set(rows)
    assert any(
        side.startswith("Friction of the load: stribeck") and name == "F_C" for side, name in rows
    )
    texts = [line.text for line in two_masses_lines(identification)]
    assert texts[0] == "motor 2 kg ± 2.0 %"
    assert two_masses_table(SimpleNamespace(two_masses=None)) is None
    assert (
        two_masses_lines(SimpleNamespace(two_masses=None, reason_for_one_mass="", treatment={}))
        == []
    )


def test_the_terminal_marks_levels_that_are_not_identified_and_states_the_constant_force(masses):
    best = masses.load.best
    assert not any(
        "not identified" in line.text
        for line in two_masses_lines(SimpleNamespace(two_masses=masses))
    )
    estimates = tuple(
        replace(item, status="at_edge") if item.name == "F_C" else item for item in best.estimates
    )
    pushed = best.friction.with_values(offset=7.0)
    side = replace(masses.load, fits=(replace(best, estimates=estimates, friction=pushed),))
    texts = [
        line.text
        for line in two_masses_lines(SimpleNamespace(two_masses=replace(masses, load=side)))
    ]
    assert [
        text
        for text in texts
        if text.startswith("friction of the load: stribeck, F_C")
        and "constant force 7 N, model error" in text
    ]
    assert sum("(not identified)" in text for text in texts) == 1


def test_a_plant_with_two_masses_explains_what_that_of_one_mass_does_not(masses, monkeypatch):
    doubts = Diagnostic("unexplained"), Diagnostic("few_strokes")
    result = replace(
        masses.motor, fits=(replace(masses.motor.best, diagnostics=doubts), *masses.motor.fits[1:])
    )
    for solved, codes in ((masses, ["few_strokes"]), ("a reason", ["unexplained", "few_strokes"])):
        monkeypatch.setattr(
            "bristle.identification.two_masses.two_masses", lambda *rest, solved=solved: solved
        )
        assert [
            item.code for item in with_two_masses(result, [], identify, None, None).best.diagnostics
        ] == codes


def test_play_that_is_not_clear_is_stated_as_a_bound(masses):
    unclear = with_quantity(masses, "play", value=0.0, half_width=3e-6, unit="m")
    assert not unclear.play_is_clear
    assert any(
        "play below 3 µm" in line.text
        for line in two_masses_lines(SimpleNamespace(two_masses=unclear))
    )


def test_an_axis_without_a_lead_keeps_its_units(masses, tmp_path):
    linear = replace(masses, arm=1.0)
    assert {linear.plant.kind, linear.motor_friction.kind, linear.table_friction.kind} == {
        "translational"
    }
    assert linear.motor_friction.values == masses.motor.best.friction.values | {"c_T": 0.15}
    assert (
        through_screw(linear.plant, linear.motor_friction, linear.table_friction).kind
        == "translational"
    )
    log = br.Log.from_columns(strokes())
    with results_folder(tmp_path / "out") as folder:
        write_two_masses(
            folder,
            SimpleNamespace(
                two_masses=linear, best=masses.load.best, log=log, treatment={"velocity_max": 0.15}
            ),
            {},
        )
    experiment = read_experiment(tmp_path / "out" / EXPERIMENT_FILE)
    assert experiment.kind == "translational"
    assert np.ptp(log.position.values) == pytest.approx(
        4.0 * experiment.variants[0].reference.values["amplitude"], rel=1e-4
    )
    text = "".join(file.read_text() for file in (tmp_path / "out").glob("*.toml"))
    assert not re.search(r"\brad\b|N\*m|kg\*m", text)


def test_the_first_screen_has_masses_coupling_and_friction_of_either_side(masses):
    result = replace(masses.motor, two_masses=masses)
    cards = {card.label: card for card in elastic_cards(result, None)}
    assert list(cards) == [
        "Mass, motor / load",
        "Stiffness",
        "Antiresonance / resonance",
        "Friction of the motor",
        "Friction of the load",
    ]
    assert cards["Mass, motor / load"].value.split("\u00a0") == ["2.00 / 10.0", "kg"]
    assert cards["Mass, motor / load"].half == pytest.approx(2.0)
    # 100 Hz times the root of 6
    assert cards["Antiresonance / resonance"].value.startswith("100 / 245")
    percent = f"{masses.motor.best.error_percent:.3g}"
    assert title_of(result).startswith(f"Model error: motor {percent}")
    assert models_of(result) == "stribeck"
    labels = [line.label for line in brief(result, None, None) if line.label]
    assert labels[:2] == ["Two masses", "One mass"]
    assert "Parameters" not in labels


def test_pictures_show_force_friction_and_lost_motion_of_both_sides(masses):
    # The twist that a stiffness of 4e6 N/m and a play of 5 µm give the measured force.
    load, force = masses.load, masses.load.best.traces.measured
    time = load.log.time.values
    full = np.interp(time, load.best.traces.time, force)
    motor_position = load.log.position.values + full / 4e6 + 2.5e-6 * np.sign(full)
    moved = replace(
        masses.motor,
        log=replace(
            masses.motor.log, position=replace(masses.motor.log.position, values=motor_position)
        ),
    )
    result = replace(masses.motor, two_masses=replace(masses, motor=moved, measured=True))
    motor, of_load, strip = force_of_both_sides(result).axes
    for axes in (motor, of_load):
        measured, model = axes.get_lines()[:2]
        assert np.ptp(measured.get_ydata()) > 0.0
        apart = np.interp(measured.get_xdata(), *model.get_data()) - measured.get_ydata()
        assert np.max(np.abs(apart)) < 0.3 * np.ptp(measured.get_ydata())
    assert "minus that of the coupling" in "".join(
        motor.get_title(loc=place) for place in ("left", "center", "right")
    )
    assert strip.get_xlim()[1] - strip.get_xlim()[0] > of_load.get_xlim()[1] - of_load.get_xlim()[0]
    curves = [steady_curve(side.best) for side in masses.sides.values()]
    assert len(friction_of_both_sides(result, curves).axes) == 2
    (axes,) = lost_motion_figure(result).axes
    points, line = axes.get_lines()[:2]
    clear = np.abs(points.get_xdata()) > 0.2 * np.max(np.abs(points.get_xdata()))
    expected = points.get_xdata() / 4.0 + 2.5 * np.sign(points.get_xdata())  # µm
    assert points.get_ydata()[clear] == pytest.approx(expected[clear], abs=0.1)
    assert np.interp(
        0.5 * line.get_xdata()[-1], line.get_xdata(), line.get_ydata()
    ) == pytest.approx(0.125 * line.get_xdata()[-1] + 2.5)
    assert not shows_lost_motion(replace(result, two_masses=replace(masses, rigid="no scale")))


def test_the_written_files_simulate_both_masses(masses, tmp_path):
    log, treatment = br.Log.from_columns(strokes()), {"velocity_max": 0.15}
    identification = SimpleNamespace(
        two_masses=masses, best=masses.load.best, log=log, treatment=treatment
    )
    with results_folder(tmp_path / "out") as folder:
        write_two_masses(folder, identification, {})
    experiment = read_experiment(tmp_path / "out" / EXPERIMENT_FILE)
    without, one_mass, both = experiment.variants
    assert all(variant.plant.values == masses.plant.values for variant in experiment.variants)
    assert all(
        variant.table.values == masses.table_friction.values for variant in experiment.variants
    )
    assert one_mass.feedforward.mass == pytest.approx(12.0 * masses.arm**2)
    assert one_mass.feedforward.friction.values["F_C"] == pytest.approx(
        masses.load.best.friction.values["F_C"] * masses.arm
    )
    assert both.feedforward.plant.values == masses.plant.values
    assert both.feedforward.table.values == masses.table_friction.values
    simulated = simulate(experiment)
    results = simulated.variants
    # The sensor is on the motor. The position is that of the table, as an angle of the motor.
    plain = results[without.name]
    assert np.ptp(plain.position) == pytest.approx(np.ptp(plain.measured), rel=0.02)
    assert np.max(np.abs(plain.position - plain.measured)) > 1e-4
    assert np.ptp(plain.measured) == pytest.approx(np.ptp(plain.reference), rel=0.2)
    old, new = (results[variant.name].true_error.rms for variant in (one_mass, both))
    assert new < 0.25 * old
    assert gain_of(simulated).headline.startswith("Feedforward of both masses: ")
    sentence = closing_sentences(simulated)[0]
    assert sentence.startswith(
        "In simulation, feedforward of both masses lowers the error of the load from "
    )
    assert "(one_mass) to " in sentence


def test_an_axis_file_names_the_second_encoder_in_its_own_unit():
    text = b"""
    schema = 1
    kind = "translational"
    columns.position = { column = "m", unit = "rev", side = "motor" }
    columns.effort = { column = "u", unit = "N*m" }
    columns.load_position = { column = "scale", unit = "mm" }
    transmission.lead = "10 mm"
    """
    time = DT * np.arange(500)
    turns = np.sin(3.0 * time)
    log = br.Log.from_columns(
        {"time": time, "m": turns, "u": np.cos(time), "scale": 10.0 * turns},
        axis=read_axis(text),
        sample_time=DT,
    )
    assert log.further["load_position"].values == pytest.approx(log.position.values)


def test_friction_of_the_motor_in_simulations_contains_that_of_the_nut(masses):
    friction, bearings = masses.motor_friction, masses.at_the_motor(masses.motor.best.friction)
    speed, pull = np.full(200, 20.0), np.linspace(-3.0, 3.0, 200)
    nut = along(friction, speed, DT, transmitted=pull) - along(bearings, speed, DT)
    assert nut == pytest.approx(0.15 * np.abs(pull), abs=1e-9)
    assert with_quantity(masses, "nut", value=0.0).motor_friction.name == bearings.name


@pytest.mark.parametrize(
    ("masked", "cause"), [(True, "rarely acts against the motion"), (False, "is too small")]
)
def test_friction_of_a_nut_that_cannot_be_separated_is_named(masses, masked, cause):
    def texts_with(half_width, value=0.0):
        nut = with_quantity(masses, "nut", value=value, half_width=half_width)
        changed = SimpleNamespace(two_masses=replace(nut, nut_is_masked=masked))
        return [line.text for line in two_masses_lines(changed)], two_masses_table(changed)

    lines, table = texts_with(0.3)
    assert cause in lines[-1]
    assert "smaller by up to 30.0 %" in lines[-1]
    assert cause in table.caption
    for clear in (texts_with(0.3, value=0.4), texts_with(0.001)):
        assert not any("does not separate" in text for text in clear[0])
    assert any(
        text.startswith("friction of the bearings and of the unloaded nut: stribeck")
        for text in texts_with(0.3, value=0.4)[0]
    )


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_log_of_the_motor_has_neither_the_force_of_the_coupling_nor_that_of_the_nut(side):
    """A stroke at constant speed with a constant twist: the nut opposes the motion, whatever the force."""
    t = DT * np.arange(4000)
    motor, force = side * 0.01 * t, 40.0
    columns = {"time": t, "position": motor, "effort": 70.0 + t}
    log = br.Log.from_columns(columns)
    twist = force / 4e6 * np.where(t < 2.0, 1.0, -1.0)
    log = replace(log, further={"load_position": replace(log.position, values=motor - twist)})
    masses = Masses(np.zeros(9), np.zeros(9), 4e6, 0.0)
    lost = LostMotion(0.0, 0.0, 0.0, 4e6, 0.0, 0.0, nut=0.2, nut_error=0.01, nut_reach=1e-5)
    of_motor, of_load = (each.effort.values[[1500, 3500]] for each in side_logs(log, masses, lost))
    assert of_load == pytest.approx([force, -force])
    assert of_motor == pytest.approx([71.5 - force - side * 8.0, 73.5 + force - side * 8.0])


@pytest.mark.parametrize(("softer", "wider"), [(0.02, 0.0), (0.0, 4e-6)])
def test_friction_is_as_uncertain_as_the_force_of_the_coupling(softer, wider):
    """The force of a coupling with another stiffness or another play differs by the stated half-width."""
    k, play, twist = 4e6, 1e-5, 4e-5
    force, other = (
        k * stretched(np.array(twist), play, 0.0),
        k * (1.0 + softer) * stretched(np.array(twist), play + wider, 0.0),
    )
    quantities = (
        Quantity("stiffness", k, softer * k, "N/m", "stiffness"),
        Quantity("play", play, wider, "m", "play"),
    )
    assert _doubt(*quantities, float(force)) == pytest.approx(abs(other - force))


def sensed(share=0.4, delay=0, **columns):
    """A motor of 2 kg with friction of 3 N, in front of a sensor; the effort is late by some samples."""
    t = DT * np.arange(4000)
    position = 0.05 * np.sin(2.0 * t) + 1e-4 * np.sin(60.0 * t)
    speed, acceleration = (
        0.1 * np.cos(2.0 * t) + 6e-3 * np.cos(60.0 * t),
        -0.2 * np.sin(2.0 * t) - 0.36 * np.sin(60.0 * t),
    )
    of_motor = 2.0 * acceleration + 3.0 * np.tanh(speed / 1e-3) * (1.0 - share)
    force = 8.0 * acceleration + 3.0 * np.tanh(speed / 1e-3) * share
    effort = np.concatenate(
        [(of_motor + force)[:1].repeat(delay), (of_motor + force)[: t.size - delay]]
    )
    return br.Log.from_columns(
        {"time": t, "position": position, "effort": effort, "coupling_effort": force} | columns
    ), of_motor


def test_the_log_of_the_motor_has_the_effort_that_the_sensor_does_not_measure():
    log, of_motor = sensed(delay=3)
    delay = effort_delay([log], 0.0)
    assert delay == pytest.approx(3.0 * DT, abs=0.05 * DT)
    effort = without_sensor(log, 0.0, delay).effort.values
    assert effort[50:-50] == pytest.approx(of_motor[50:-50], abs=0.05)


@pytest.mark.parametrize(
    ("factor", "fault"),
    [
        (-1.0, "has the opposite sign of the effort.*Write sign = -1"),
        (1e3, "does not measure a part of the effort.*Check unit and side"),
    ],
)
def test_a_sensor_with_a_wrong_sign_or_unit_is_refused(factor, fault):
    log, _ = sensed()
    wrong, _ = sensed(coupling_effort=factor * log.further["coupling_effort"].values)
    with pytest.raises(InputError, match=rf"columns\.coupling_effort: {fault}"):
        two_masses([(wrong, None)], identify)
    assert behind_sensor(log).effort.values == pytest.approx(log.further["coupling_effort"].values)


AXIS = """
schema = 1
kind = "translational"
columns.position = { column = "m", unit = "rev", side = "motor" }
columns.effort = { column = "i", unit = "A" }
columns.coupling_effort = { column = "T", unit = "UNIT", sign = -1 }
effort.torque_constant = "0.1 N*m/A"
transmission.lead = "10 mm"
"""


def test_an_axis_file_names_the_sensor_in_its_own_unit_and_sign():
    t = DT * np.arange(500)
    columns = {"time": t, "m": np.sin(3.0 * t), "i": np.cos(t), "T": -50.0 * np.cos(t)}
    log = br.Log.from_columns(
        columns, axis=read_axis(AXIS.replace("UNIT", "mN*m").encode()), sample_time=DT
    )
    assert log.further["coupling_effort"].values == pytest.approx(0.5 * log.effort.values)
    assert log.further["coupling_effort"].unit == "N"
    with pytest.raises(
        InputError,
        match=r"columns\.coupling_effort\.unit: is not a unit of torque or force; found 'A'",
    ):
        read_axis(AXIS.replace("UNIT", "A").encode())


def test_without_a_scale_the_load_is_rigid_behind_the_sensor(tmp_path):
    log, _ = sensed(share=0.4)
    found = two_masses(
        [(log, None)], partial(identify, model="coulomb_viscous", axis=STATED, draws=0, blocks=0)
    )
    assert {name: item.value for name, item in found.by_name.items()} == pytest.approx(
        {"motor": 2.0, "load": 8.0}, rel=0.02
    )
    assert found.motor.best.parameters["F_C"].value == pytest.approx(1.8, rel=0.05)
    assert found.load.best.parameters["F_C"].value == pytest.approx(1.2, rel=0.05)
    assert not found.is_elastic
    # Unknown without the motion of the load.
    assert found.as_data()["quantities"]["load"]["half_width"] is None
    low, high = found.load.best.parameters["F_C"].ends
    assert high - low > 0.29 * 1.2
    result = SimpleNamespace(two_masses=found, log=log)
    assert any(
        line.text.startswith("Without a second encoder, the load is rigid behind the sensor")
        for line in two_masses_lines(result)
    )
    assert "from the sensor in the coupling" in two_masses_table(result).caption
    with results_folder(tmp_path / "out") as folder:
        folder.write("note.txt", "no plant")
        write_two_masses(folder, result, {})
    assert not list((tmp_path / "out").glob("two_masses*"))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [4003, 4000])
def test_a_sensor_separates_friction_of_the_motor_from_that_behind_it(seed):
    drive = with_sensor(seed, has_nut=True)
    fit = partial(identify, model="lugre", blocks=0, draws=0)
    pairs = [
        (br.Log.from_columns(columns), br.Axis(resolution=drive.step))
        for columns in (log_of(drive), of_the_motor(log_of(drive)))
    ]
    both, without_scale = two_masses(pairs[:1], fit), two_masses(pairs[1:], fit)
    truths = {
        "motor": drive.motor - drive.screw,
        "load": drive.load,
        "stiffness": drive.stiffness,
        "nut": drive.nut,
    }
    for name, truth in truths.items():
        assert abs(both.by_name[name].value - truth) <= both.by_name[name].half_width
    levels = [side.best.parameters["F_C"] for side in (both.motor, both.load, without_scale.motor)]
    for level, truth in zip(
        levels, [drive.friction[0][1], drive.friction[1][1], drive.friction[0][1]], strict=True
    ):
        assert level.ends[0] < truth < level.ends[1]
        assert level.ends[1] - level.ends[0] < 0.1 * truth


def test_the_force_between_both_sides_has_the_loss_of_a_coupling_with_hysteresis():
    """A triangular twist at a constant speed: the force on the load returns less work than it took."""
    t, amplitude, reach = DT * np.arange(8000), 2e-5, 5e-6
    twist = amplitude * (4.0 * np.abs((0.5 * t) % 1.0 - 0.5) - 1.0)
    log = br.Log.from_columns({"time": t, "position": 0.01 * t, "effort": 70.0 + t})
    log = replace(
        log, further={"load_position": replace(log.position, values=log.position.values - twist)}
    )
    lost = LostMotion(
        0.0,
        0.0,
        0.0,
        4e6,
        0.0,
        0.0,
        hysteresis=Hysteresis(30.0, 0.0, 4e6, 7e6, 0.0, ((15.0, reach),)),
    )
    motor, load = (
        side.effort.values
        for side in side_logs(log, Masses(np.zeros(9), np.zeros(9), 4e6, 0.0), lost)
    )
    assert motor + load == pytest.approx(log.effort.values)
    cycle = slice(4000, 6001)
    assert np.trapezoid(load[cycle], twist[cycle]) == pytest.approx(
        4.0 * 15.0 * (amplitude - reach), rel=0.02
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", [905, 3009])
def test_hysteresis_of_the_coupling_does_not_bias_friction_of_either_side(seed):
    drive = drive_of(seed)
    twist = log_of(drive)["position"] - log_of(drive)["load_position"]
    drive = replace(
        drive, hysteresis=(0.2, 0.15 * float(np.ptp(np.quantile(twist, [0.005, 0.995]))))
    )
    log = br.Log.from_columns(log_of(drive))
    found = two_masses(
        [(log, br.Axis(resolution=drive.step))], partial(identify, model="lugre", blocks=0, draws=0)
    )
    for side, truth in zip(found.sides.values(), drive.friction, strict=True):
        assert side.best.parameters["F_C"].value == pytest.approx(truth[1], rel=0.03)


def test_a_load_behind_a_coupling_is_where_its_spring_holds_it():
    log, _ = sensed()
    stiffness, force = 2e5, log.further["coupling_effort"].values
    load = alone(log, force, load=True, softness=1.0 / stiffness)
    assert stiffness * (log.position.values - load.position.values) == pytest.approx(
        force, abs=1e-9
    )
    assert np.array_equal(load.effort.values, force)
