"""The numbers of a measured axis that the pages quote are those that come out."""

import re
from dataclasses import replace

import pytest
from tests.docs.conftest import ROOT
from tests.examples.data import measured

from bristle.files.axis import read_axis
from bristle.identification import identify
from bristle.logs import read_log
from bristle.prediction import predict
from bristle.prediction.following import loop_of
from bristle.simulation import simulate

pytestmark = pytest.mark.measured

EMPS = ROOT / "examples" / "emps"
DECISIONS = ROOT / "docs" / "decisions"


@pytest.fixture(scope="module")
def axis():
    return read_axis(EMPS / "axis.toml")


@pytest.fixture(scope="module")
def log(axis):
    return read_log(measured("emps", "DATA_EMPS.mat"), axis)


@pytest.fixture(scope="module")
def fits(log, axis):
    identification = identify(log, "coulomb_viscous,coulomb_viscous+asymmetry", axis=axis, draws=0)
    return {fit.name: fit for fit in identification.fits}


def rows(page, first=""):
    """The numbers in each row of the tables of a page whose first cell begins so."""
    result = []
    for line in page.read_text().replace("−", "-").splitlines():
        if line.startswith(f"| {first}") and re.search(r"\d", line):
            result.append(
                [
                    float(item)
                    for item in re.findall(r"(?<![\w+])-?\d+\.?\d*", line.partition("|")[2])
                ]
            )
    return result


def test_the_symmetric_table(fits):
    fit = fits["coulomb_viscous"]
    for name in ("M", "F_v", "F_C", "offset"):
        published, published_std, ours, ours_std, apart = rows(EMPS / "README.md", name)[0][-5:]
        estimate = fit.parameters[name]
        assert estimate.value == pytest.approx(ours, abs=1e-4)
        assert estimate.relative_std_percent == pytest.approx(ours_std, abs=1e-3)
        distance = abs(estimate.value - published) / (published_std / 100 * abs(published))
        assert distance == pytest.approx(apart, abs=0.01)
    assert fit.force_error_percent == pytest.approx(
        rows(EMPS / "README.md", "force error")[0][-1], abs=1e-4
    )


def test_the_table_by_direction(fits):
    fit = fits["coulomb_viscous+asymmetry"]
    for first, names in (
        ("F_v forward", ("F_v_pos", "F_v_neg")),
        ("F_C forward", ("F_C_pos", "F_C_neg")),
    ):
        ours = rows(EMPS / "README.md", first)[0][-2:]
        assert [fit.parameters[name].value for name in names] == pytest.approx(ours, abs=1e-4)
    assert fit.force_error_percent == pytest.approx(
        rows(EMPS / "README.md", "force error")[1][-1], abs=1e-4
    )


@pytest.mark.slow
def test_the_effort_with_zero_order_hold(log, axis):
    fixed = replace(axis, held=True)
    identification = identify(
        log, "coulomb_viscous,coulomb_viscous+asymmetry", axis=fixed, blocks=0, draws=0
    )
    fits = {fit.name: fit for fit in identification.fits}
    message = (
        (EMPS / "README.md")
        .read_text()
        .partition("With this key,")[2]
        .partition("beyond the published")[0]
    )
    numbers = [float(item) for item in re.findall(r"\d+\.\d+", message)]
    symmetric = fits["coulomb_viscous"]
    assert numbers == pytest.approx(
        [
            symmetric.force_error_percent,
            fits["coulomb_viscous+asymmetry"].force_error_percent,
            *(symmetric.parameters[name].value for name in ("M", "F_v", "F_C")),
        ],
        rel=2e-4,
    )


@pytest.mark.slow
def test_the_presliding_distance(fits, log, axis):
    table = rows(DECISIONS / "0005-presliding-distance-in-loops.md", "2 ")
    table += rows(DECISIONS / "0005-presliding-distance-in-loops.md", "10 ")
    for distance, symmetric, by_direction in table:
        at = replace(axis, presliding=1e-6 * distance)
        for name, error in (
            ("coulomb_viscous", symmetric),
            ("coulomb_viscous+asymmetry", by_direction),
        ):
            prediction = predict(fits[name].plant, fits[name].friction, log, at, "closed-loop")
            assert prediction.metrics["force_error_percent"] == pytest.approx(error, abs=1e-3)
    symmetric, by_direction = rows(DECISIONS / "0005-presliding-distance-in-loops.md", "instant")[0]
    instant = replace(axis, presliding=None)
    prediction = predict(
        fits["coulomb_viscous"].plant, fits["coulomb_viscous"].friction, log, instant, "closed-loop"
    )
    assert prediction.metrics["force_error_percent"] == pytest.approx(symmetric, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("page", [ROOT / "README.md", EMPS / "README.md"], ids=["README", "emps"])
def test_the_errors_in_closed_loop(page, fits, log, axis):
    for name, fit in fits.items():
        message = rows(page, f"`{name}` |")[0]
        result = [
            predict(
                fit.plant, fit.friction, log, replace(axis, presliding=distance), "closed-loop"
            ).metrics
            for distance in (None, axis.presliding)
        ]
        assert [item["force_error_percent"] for item in result] == pytest.approx(message, abs=0.006)


@pytest.mark.parametrize("first", ["with the replay", "without"])
def test_the_replay_of_the_unexplained_force(first, fits, log, axis):
    fit = fits["coulomb_viscous"]
    loop = loop_of(fit.plant, fit.friction, log, axis)
    if first == "without":
        loop = replace(
            loop, variants=tuple(replace(variant, disturbance=None) for variant in loop.variants)
        )
    peaks = [
        1e6 * variant.following_error.peak_to_peak for variant in simulate(loop).variants.values()
    ]
    recorded, *simulated = rows(DECISIONS / "0006-unexplained-force-is-replayed.md", first)[0]
    assert peaks == pytest.approx(simulated, abs=0.06)
    error = (log.reference.values - log.position.values)[500:]
    assert 1e6 * (error.max() - error.min()) == pytest.approx(recorded, abs=0.06)
