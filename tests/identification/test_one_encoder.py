"""Both masses of an elastic axis from the encoder of the motor; the simulated drives share no code with the identification."""

from dataclasses import dataclass, replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from benchmarks.two_mass import columns_of, drive_of
from tests.identification.rigid import IDENTIFYING
from tests.identification.watched import watched

import bristle as br
from bristle.core import Axis, with_unit
from bristle.files import read_experiment, results_folder
from bristle.identification import identify, one_encoder
from bristle.identification.elasticity import Elastic, Masses, elastic_coupling
from bristle.identification.one_encoder import CUT, OneEncoder, with_masses
from bristle.identification.two_encoders import (
    A_1,
    A_2,
    EFFORT,
    SIGNALS,
    TWIST,
    TWIST_RATE,
    UNKNOWN,
    V_1,
    V_2,
    Prior,
    Spectra,
)
from bristle.identification.two_masses import with_masses_of
from bristle.report.figures.two_masses import response_of_motor
from bristle.report.two_masses import (
    ALL_AT_THE_MOTOR,
    EXPERIMENT_FILE,
    TABLE_FILE,
    elastic_cards,
    title_of,
    two_masses_lines,
    two_masses_table,
    write_two_masses,
)

# Masses, coupling, viscous friction, delay, hold.
POINT = np.array([3.0, 5.0, 4e-4, 2e-3, 7.0, 9.0, 1.5e-3, 0.0, 0.0, 0.4])


@cache
def found_in(seed):
    drive = drive_of(seed)
    pairs = [(br.Log.from_columns(columns_of(drive)), Axis(resolution=drive.step))]
    coupling = elastic_coupling(*map(list, zip(*pairs, strict=True)))
    return drive, coupling, with_masses(coupling, pairs)


@pytest.fixture(scope="module")
def found():
    """The one identification of these tests: its drive, its result, the response of the motor, and the fit of both masses."""
    drive = drive_of(742)
    with watched(
        (IDENTIFYING, "with_masses"), (one_encoder, "spectra_of"), (one_encoder, "_solution")
    ) as calls:
        result = identify(
            columns_of(drive),
            "coulomb_viscous",
            axis=Axis(resolution=drive.step),
            blocks=0,
            draws=0,
        )
    (response, pairs), coupling = calls["with_masses"][0]
    spectra, solution = calls["spectra_of"][0].returned, calls["_solution"][0].returned
    return SimpleNamespace(
        drive=drive,
        result=result,
        pairs=pairs,
        response=response,
        coupling=coupling,
        spectra=spectra,
        solution=solution,
    )


@pytest.fixture
def solved(found, monkeypatch):
    """The fit of both masses is the one that was found."""
    monkeypatch.setattr(one_encoder, "spectra_of", lambda *_, **__: found.spectra)
    monkeypatch.setattr(one_encoder, "_solution", lambda *_: found.solution)
    return found


def fit_at(hertz, noise=0.0):
    count = hertz.size
    spectra = Spectra(
        hertz,
        np.ones(count),
        np.zeros((1, count, SIGNALS, SIGNALS)),
        np.ones(1),
        np.diag([noise, 0.0]),
        1e-3,
    )
    return OneEncoder(spectra, UNKNOWN, np.zeros((count, 1, 1), complex))


def test_the_equation_holds_for_two_masses_and_any_position_of_the_load():
    hertz = np.array([3.0, 7.9, 8.0, 20.0, 90.0])
    s, (m_1, m_2, kappa, damping, c_1, c_2, delay) = 2j * np.pi * hertz, POINT[:7]
    k = m_2 / kappa
    link = k + k * damping * s
    matrix = np.moveaxis(
        np.array([[m_1 * s**2 + c_1 * s + link, -link], [-link, m_2 * s**2 + c_2 * s + link]]), 2, 0
    )
    motor = np.linalg.solve(
        matrix, np.broadcast_to(np.array([1.0, 0.0])[:, None], (hertz.size, 2, 1))
    )[:, 0, 0]
    signals = np.zeros((hertz.size, SIGNALS), complex)
    load = np.random.default_rng(1).normal(size=hertz.size) * np.abs(motor)
    # The recorder holds the motion, and the effort acts later than recorded.
    signals[:, EFFORT] = np.exp(-s * delay) * np.sinc(1e-3 * hertz) ** -0.4
    for place, value in (
        (A_1, s**2 * motor),
        (A_2, s**2 * load),
        (V_1, s * motor),
        (V_2, s * load),
    ):
        signals[:, place] = value
    signals[:, TWIST], signals[:, TWIST_RATE] = motor - load, s * (motor - load)
    residual = np.einsum("gi,gi->g", fit_at(hertz).equations(POINT)[:, 0], signals)
    assert np.max(np.abs(residual)) < 1e-9


def test_noise_of_the_encoder_is_as_large_as_its_residual():
    hertz, step = np.array([3.0, 20.0, 90.0]), 2e-6
    s, fit = 2j * np.pi * hertz, fit_at(hertz, step**2)
    signals = np.zeros((hertz.size, SIGNALS), complex)
    for place, gain in ((A_1, s**2), (V_1, s), (TWIST, 1.0), (TWIST_RATE, s)):
        signals[:, place] = gain * step
    residual = np.einsum("gi,gi->g", fit.equations(POINT)[:, 0], signals)
    assert fit.noise(POINT)[:, 0, 0] == pytest.approx(np.abs(residual) ** 2)


def agrees(drive, coupling):
    assert coupling.masses.values[:2] == pytest.approx([drive.motor, drive.load], rel=0.015)
    assert coupling.masses.stiffness == pytest.approx(drive.stiffness, rel=0.03)
    assert coupling.mass == pytest.approx(drive.total, rel=0.01)
    assert coupling.antiresonance == pytest.approx(drive.antiresonance, rel=0.01)
    for name, truth in (
        ("mass", drive.total),
        ("antiresonance", drive.antiresonance),
        ("inertia_ratio", drive.load / drive.motor),
    ):
        assert abs(getattr(coupling, name) - truth) < getattr(coupling, f"{name}_half_width")


def test_both_masses_and_their_sum_are_those_of_the_drive(found):
    agrees(found.drive, found.coupling)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [719, 730, 761])  # 719 with play
def test_both_masses_and_their_sum_are_those_of_any_drive(seed):
    drive, _, coupling = found_in(seed)
    agrees(drive, coupling)


def test_the_more_precise_mass_and_frequency_are_reported(solved):
    response, coupling = solved.response, solved.coupling
    assert coupling.antiresonance_half_width <= response.antiresonance_half_width
    width = 0.5 * coupling.antiresonance_half_width
    sharp = with_masses(response._replace(antiresonance_half_width=width), solved.pairs)
    assert (sharp.antiresonance, sharp.antiresonance_half_width) == (response.antiresonance, width)
    assert coupling.mass_half_width < 2.0 * response.mass_half_width
    width = 0.4 * coupling.mass_half_width  # friction doubles the error of the response
    sharp = with_masses(response._replace(mass_half_width=width), solved.pairs)
    assert (sharp.mass, sharp.mass_half_width) == (response.mass, 2.0 * width)


@pytest.mark.slow
def test_a_load_that_vibrates_for_long_does_not_change_the_sum_of_the_masses():
    drive, response, coupling = found_in(719)
    assert abs(response.mass / drive.total - 1.0) > 0.05
    assert abs(coupling.mass / drive.total - 1.0) < 0.01


def test_the_result_has_both_masses_and_all_friction_at_the_motor(found):
    drive, result = found.drive, found.result
    masses = result.two_masses
    assert [item.name for item in masses.quantities] == [
        "motor",
        "load",
        "stiffness",
        "damping",
        "antiresonance",
    ]
    for name, truth in (
        ("motor", drive.motor),
        ("load", drive.load),
        ("stiffness", drive.stiffness),
    ):
        assert (
            abs(masses.by_name[name].value - truth) < masses.by_name[name].half_width < 0.25 * truth
        )
    assert not masses.play_is_clear
    assert masses.load is None
    assert set(masses.as_data()) == {"quantities", "delay", "play_is_clear", "motor_friction"}
    assert masses.motor_friction.values["F_C"] == pytest.approx(result.best.friction.values["F_C"])
    assert result.treatment["antiresonance"] == pytest.approx(masses.by_name["antiresonance"].value)
    assert masses.by_name["motor"].value + masses.by_name["load"].value == pytest.approx(
        result.best.parameters["M"].value, rel=0.01
    )


def test_the_response_of_the_motor_is_that_of_two_masses(found):
    drive, result = found.drive, found.result
    response = result.response
    omega = 2.0 * np.pi * response.frequency
    spring = (
        drive.stiffness
        + 1j * omega * 2.0 * drive.damping * drive.load * 2.0 * np.pi * drive.antiresonance
    )
    link = drive.load * spring / (spring - drive.load * omega**2)  # apparent mass of the load
    exact = 1.0 / np.abs(drive.motor + link)
    away = (response.coherence > 0.9) & (
        np.abs(np.log(response.frequency / drive.resonance)) > 0.15
    )
    away &= np.abs(np.log(response.frequency / drive.antiresonance)) > 0.15
    assert np.count_nonzero(away) > 10
    assert np.median(np.abs(response.gain[away] / exact[away] - 1.0)) < 0.05
    assert response.modelled[away] == pytest.approx(exact[away], rel=0.1)
    (axes,) = response_of_motor(result.best, result).axes
    places = sorted(line.get_xdata()[0] for line in axes.get_lines() if len(line.get_xdata()) == 2)
    assert places == pytest.approx([drive.antiresonance, drive.resonance], rel=0.02)
    assert axes.get_ylabel() == "Acceleration per force [1/kg]"
    assert title_of(result).startswith(f"Antiresonance {with_unit(places[0], 'Hz')}, resonance")
    assert [card.label for card in elastic_cards(result, None)][:3] == [
        "Mass, motor / load",
        "Stiffness",
        "Antiresonance / resonance",
    ]


def test_report_terminal_and_files_state_one_friction(found, tmp_path):
    result = found.result
    table = two_masses_table(result)
    assert ALL_AT_THE_MOTOR in str(table.caption)
    assert not any(str(row[0]).startswith("Friction") for row in table.rows)
    assert two_masses_lines(result)[-1].text == ALL_AT_THE_MOTOR
    damping = result.two_masses.by_name["damping"]
    assert 0.0 < damping.value < damping.half_width  # only an upper bound
    bound = f"below {with_unit(damping.value + damping.half_width, damping.unit)}"
    assert ("Damping", bound, "–") in [tuple(map(str, row[1:])) for row in table.rows]
    assert f"damping {bound}" in [line.text for line in two_masses_lines(result)]
    with results_folder(tmp_path / "out") as folder:
        write_two_masses(folder, result, {})
    assert not (tmp_path / "out" / TABLE_FILE).exists()
    *_, both = read_experiment(tmp_path / "out" / EXPERIMENT_FILE).variants
    assert both.plant.values == both.feedforward.plant.values == result.two_masses.plant.values
    assert both.table is None
    assert both.friction.values == result.two_masses.motor_friction.values


def test_masses_that_the_log_does_not_determine_are_refused_with_the_reason(found):
    result = found.result
    pairs, response = (
        [(result.log, None)],
        Elastic(40.0, 0.1, 60.0, 0.1, 1.25, 0.01, 12.0, 0.1, 0.0, 1e-4, "a reason"),
    )
    alone = replace(result, two_masses=None)
    assert with_masses_of(alone, pairs, None) is alone
    assert (
        with_masses_of(alone, pairs, response).left_out["the plant with two masses"] == "a reason"
    )
    texts = [line.text for line in two_masses_lines(with_masses_of(alone, pairs, response))]
    assert texts[0] == "not determined: a reason"
    assert [text.split()[0] for text in texts[1:]] == ["antiresonance", "resonance"]
    errors = np.array([0.3, 0.1, 1e-6, 1e-4, *np.zeros(6)])
    values = np.array([3.0, 5.0, *POINT[2:]])
    for factor, refused in ((0.1, False), (1.0, True)):
        masses = Masses(values, factor * errors, 5.0 / 4e-4, 1.0)
        again = with_masses_of(
            alone, pairs, response._replace(masses=masses, mass_half_width=100.0)
        )
        assert (again.two_masses is None) == refused
        assert (
            "mass of the motor only within 40 %"
            in again.left_out.get("the plant with two masses", "")
        ) == refused


def test_masses_whose_sum_is_not_that_of_the_axis_are_refused(found):
    result = found.result
    coupling = found.coupling
    for share in (1.0, 0.8):
        again = with_masses_of(
            replace(result, two_masses=None),
            [(result.log, None)],
            coupling._replace(mass=share * coupling.mass),
        )
        assert (again.two_masses is None) == (share < 1.0)
        assert (
            "the recorded effort may have passed a filter"
            in again.left_out.get("the plant with two masses", "")
        ) == (share < 1.0)


@pytest.mark.parametrize("names", [("antiresonance", "resonance"), ("resonance",)])
def test_a_fit_with_other_frequencies_is_refused(solved, names):
    off = {name: 1.4 * getattr(solved.response, name) for name in names}
    assert "other frequencies" in with_masses(solved.response._replace(**off), solved.pairs).masses


@dataclass(frozen=True)
class Fitted:
    """A fit of masses of 1 each that ends at this antiresonance [rad/s] without prior knowledge, and at that of the prior with it."""

    prior: Prior
    free: float
    error: float

    def converged(self, start):
        return None, np.array([1.0, 1.0, self.free**-2.0, 0.0])

    def solution(self, point):
        return SimpleNamespace(point=point, error=lambda of: np.full(2, self.error))


@pytest.mark.parametrize(
    ("free", "error", "contradicted"),
    [
        (100.0, 1e-4, False),
        (101.5, 1e-4, True),  # by more than ten standard errors of the response
        (101.5, 2e-3, False),  # and not of the fit, which is less precise
        (125.0, 1e-4, False),  # another pair of masses
    ],
)
def test_a_precise_fit_that_contradicts_the_response_does_without_it(free, error, contradicted):
    start = np.array([1.0, 1.0, 1e-4, 0.0])
    fit = Fitted(Prior(np.log([100.0, 100.0 * 2.0**0.5]), np.full(2, 1e-3)), free, error)
    solved, differs = one_encoder._solution(fit, start)
    assert differs == contradicted
    assert solved.point[2] == pytest.approx(free**-2.0 if contradicted else 1e-4)


@pytest.mark.slow
def test_the_frequencies_of_a_contradicted_response_are_corrected():
    drive, coupling, with_both = found_in(635)
    truth = np.array([drive.antiresonance, drive.resonance])
    # The error of the response.
    assert (
        np.min(np.abs(np.array([coupling.antiresonance, coupling.resonance]) / truth - 1.0)) > 0.1
    )
    assert (
        np.max(np.abs(np.array([with_both.antiresonance, with_both.resonance]) / truth - 1.0))
        < 0.01
    )
    assert abs(with_both.mass / drive.total - 1.0) < 0.01


@pytest.mark.slow
def test_a_less_precise_fit_keeps_the_frequencies_of_the_response():
    drive, coupling, with_both = found_in(1409)
    for name in ("antiresonance", "resonance"):
        truth = getattr(drive, name)
        assert abs(getattr(coupling, name) / truth - 1.0) < 0.02
        assert abs(getattr(with_both, name) / truth - 1.0) < 0.03


def test_short_strokes_have_no_masses(found):
    ((log, axis),) = found.pairs
    count = round(1.5 * CUT.shortest / log.sample_time)
    short = br.Log.from_columns(
        {name: column[:count] for name, column in columns_of(found.drive).items()}
    )
    assert "too few strokes" in with_masses(found.response, [(short, axis)]).masses
