"""A measured axis: motor, ball screw and table in closed loop, with published results.

A. Janot, M. Gautier, M. Brunot, "Data Set and Reference Models of EMPS", Workshop on Nonlinear System Identification
Benchmarks, 2019.
"""

import pytest
from scipy.io import loadmat
from tests.examples.data import measured
from tests.identification import rigid

from bristle.core import Axis
from bristle.identification import identify
from bristle.logs.log import Channel, Log
from bristle.report.messages import warnings_of

pytestmark = pytest.mark.measured


@pytest.fixture(scope="module")
def emps() -> Log:
    record = loadmat(measured("emps", "DATA_EMPS.mat"))
    time, position, voltage = (record[name].ravel() for name in ("t", "qm", "vir"))
    return Log(
        time=Channel(time, "s", "t"),
        position=Channel(position, "m", "qm"),
        effort=Channel(voltage * record["gtau"].item(), "N", "vir"),
        sample_time=1e-3,
        segments=(slice(0, time.size),),
    )


# The treatment, with its decimation by 10, and no force beside friction and inertia.
PUBLISHED = Axis(seeks_delay=False, cutoff=100.0, settings={"lines_gain": 1.0})


@pytest.fixture(scope="module")
def symmetric(emps):
    return rigid.identify(emps, "coulomb_viscous", axis=PUBLISHED, draws=0).best


@pytest.fixture(scope="module")
def undelayed(emps):
    """A fit for which nothing is stated about the delay."""
    return identify(emps, "coulomb_viscous", draws=0, blocks=0).best


def test_symmetric_friction_as_published(symmetric):
    published = {
        "M": (95.1089, 0.114),
        "F_v": (203.5034, 0.563),
        "F_C": (20.3935, 0.496),
        "offset": (-3.1648, 1.402),
    }
    for name, (value, percent) in published.items():
        estimate = symmetric.parameters[name]
        assert abs(estimate.value - value) < 0.5 * abs(value) * percent / 100.0, name
        assert 1.0 / 1.5 < estimate.relative_std_percent / percent < 1.5, name
    assert 4.0 < symmetric.force_error_percent < 4.2
    assert "motion_repeats" in {diagnostic.code for diagnostic in symmetric.diagnostics}
    for name, ratio in {"M": 1.8, "F_v": 5.5, "F_C": 4.8, "offset": 4.4}.items():
        parameter = symmetric.parameters[name]
        # Residuals are correlated
        assert parameter.robust_std / parameter.std == pytest.approx(ratio, rel=0.1), name


def test_the_symmetric_model_lacks_directions_beside_a_ripple_of_the_screw(undelayed):
    missing = {
        diagnostic.code: diagnostic.numbers
        for diagnostic in undelayed.diagnostics
        if diagnostic.code.startswith("missing_")
    }
    assert missing["missing_direction"]["model"] == "coulomb_viscous+asymmetry"
    assert undelayed.plant.values["motor_turn"] == pytest.approx(2.5e-3, rel=2e-3)


def test_friction_by_direction_as_published(emps):
    result = rigid.identify(
        emps, "coulomb_viscous,coulomb_viscous+asymmetry", axis=PUBLISHED, draws=0
    )
    fit = result.best
    published = {
        "M": 95.154,
        "F_v_pos": 166.71,
        "F_v_neg": 240.42,
        "F_C_pos": 20.144,
        "F_C_neg": 20.628,
    }
    assert fit.name == "coulomb_viscous+asymmetry"
    for name, value in published.items():
        assert fit.parameters[name].value == pytest.approx(value, rel=0.01), name
    assert 3.1 < fit.force_error_percent < 3.25
    assert fit.held_out.mean_percent < 0.8 * result.fits[1].held_out.mean_percent


def test_without_a_stated_delay_the_command_leads_the_position(undelayed):
    assert 94.2 < undelayed.parameters["M"].value < 95.6
    lead = next(
        diagnostic.numbers
        for diagnostic in undelayed.diagnostics
        if diagnostic.code == "delay_found"
    )
    assert -0.95e-3 < lead["delay"] < -0.65e-3
    assert lead["half_width"] < 0.15e-3


@pytest.mark.parametrize(
    "cutoff", [20.0, *(pytest.param(cutoff, marks=pytest.mark.slow) for cutoff in (10.0, 50.0))]
)
def test_other_cutoffs_find_the_same_mechanism(emps, cutoff):
    fit = rigid.identify(
        emps, "coulomb_viscous", axis=PUBLISHED, cutoff=cutoff, draws=0, blocks=0
    ).best
    for name, value in {"M": 95.1089, "F_v": 203.5034, "F_C": 20.3935, "offset": -3.1648}.items():
        assert fit.parameters[name].value == pytest.approx(value, rel=0.015), name
    assert 3.0 < fit.force_error_percent < 4.2


@pytest.mark.slow
def test_a_model_half_unidentified_is_not_the_first(emps):
    models = "lugre+asymmetry,coulomb_viscous+asymmetry,coulomb_viscous"
    result = identify(emps, models, draws=0, settings={"lines_gain": 1.0})
    assert [fit.name for fit in result.fits] == [
        "coulomb_viscous+asymmetry",
        "lugre+asymmetry",
        "coulomb_viscous",
    ]
    first, second, _ = (fit.held_out.mean_percent for fit in result.fits)
    assert second < first < 1.05 * second


@pytest.mark.slow
def test_seven_reversals_do_not_show_presliding(emps):
    result = identify(emps, "lugre,dahl", axis=PUBLISHED, draws=0)
    for fit in result.fits:
        warning = next(
            item for item in warnings_of(fit) if item.startswith("sigma_0 cannot be identified")
        )
        assert "only 7 reversals" in warning
    lugre = next(fit for fit in result.fits if fit.name == "lugre")
    assert lugre.parameters["sigma_1"].status == "unidentifiable"
    assert lugre.parameters["F_C"].status == "identified"
    assert lugre.parameters["F_C"].value == pytest.approx(20.39, rel=0.02)
