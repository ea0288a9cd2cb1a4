"""Functions of a model in continuous time, run as they stand: rates, what begins a piece, what an event commits."""

import math

import numpy as np
import pytest
from tests.exports.native import example_with

import bristle as br
from bristle.core.contracts import Motion
from bristle.engine import interpreted
from bristle.exports.cycle import core_of
from bristle.exports.fmu_exchange import BEYOND, exchange_of
from bristle.exports.subject import subject_of
from bristle.translation.build import Builder

LUGRE = br.friction.lugre(F_C=22.0, F_S=29.0, v_S=3e-3, sigma_0=2e6, sigma_1=1e3, sigma_2=40.0)
BOUC_WEN, NESTED = example_with("bouc_wen"), example_with("preisach_lugre")
MASS = br.plants.inertia(M=2.5)


@pytest.fixture(autouse=True)
def in_plain_python():
    with interpreted():
        yield


class Importer:
    """What an importer keeps of an FMU, and how it calls its functions."""

    def __init__(self, model, plant=None):
        builder = Builder()
        self.core = core_of(subject_of(model), plant, builder)
        self.exchange = exchange_of(self.core, builder)
        self.values = {
            "lasting": np.array(self.core.begin, dtype=float),
            "memory": np.array(model.component.new_memory(model.parameters), dtype=float),
            "varying": np.zeros(len(self.exchange.varying)),
            "held": np.zeros(len(self.exchange.held)),
            "slope": np.full(len(self.exchange.varying) + 2, np.nan),
            "p": model.parameters,
        } | ({} if plant is None else {"q": plant.parameters})

    @classmethod
    def moving(cls, model, v=1e-3, plant=None):
        """Return an importer behind the start of a motion."""
        importer = cls(model, plant)
        importer.call("begun", v=v, x=0.0)
        return importer

    def __getitem__(self, name):
        return self.values[name]

    def call(self, name, **inputs):
        function, values = getattr(self.exchange, name), self.values | inputs
        return function.source(*(values[parameter.name] for parameter in function.parameters))


@pytest.mark.parametrize(("z", "v"), [(0.0, 1e-3), (1e-6, 2e-3), (-3e-6, -1e-3)])
def test_a_model_with_rates_only_gives_force_and_rates(z, v):
    importer = Importer(BOUC_WEN)
    assert importer.exchange.held == ()
    component, p = BOUC_WEN.component, BOUC_WEN.parameters
    importer["varying"][0] = z
    force, rates = component.rate(component.State(z), Motion(v, 0.3), p)
    assert importer.call("flowing", v=v, x=0.3) == force
    assert importer["slope"][0] == rates[0]
    assert np.isnan(importer["slope"][1:]).all()  # no event is looked for


def test_a_mass_moves_with_its_velocity_and_friction_brakes_it():
    importer = Importer(BOUC_WEN, MASS)
    assert list(importer.exchange.varying)[:2] == ["x", "v"]
    importer["varying"][:] = [0.3, 2e-3, 1e-6]
    force = importer.call("flowing", effort=7.0)
    component = BOUC_WEN.component
    expected, rates = component.rate(component.State(1e-6), Motion(2e-3, 0.3), BOUC_WEN.parameters)
    assert force == expected
    assert importer["slope"][:3].tolist() == [2e-3, pytest.approx((7.0 - force) / 2.5), rates[0]]


def test_the_states_of_a_mass_are_copied_at_the_start_and_at_events():
    importer = Importer(BOUC_WEN, MASS)
    importer["lasting"][:3] = [0.3, 2e-3, 1e-6]
    importer.call("begun")
    assert importer["varying"].tolist() == [0.3, 2e-3, 1e-6]
    importer["varying"][:] = [0.4, 3e-3, 2e-6]
    importer.call("arrived")
    assert importer["lasting"][:3].tolist() == [0.4, 3e-3, 2e-6]


@pytest.mark.parametrize("v", [1e-3, -1e-3])
def test_a_piece_begins_in_the_direction_of_the_motion_with_its_contact(v):
    importer = Importer(LUGRE)
    importer["lasting"][0] = 1e-6
    importer.call("begun", v=v, x=0.0)
    side, contact = importer["held"]
    assert (side, contact, importer["varying"].tolist()) == (math.copysign(1.0, v), 1e-6, [1e-6])


def test_after_a_reversal_a_piece_continues_and_its_indicator_is_negative():
    importer = Importer.moving(LUGRE)
    importer["varying"][0] = 1e-6  # far from the event
    importer.call("flowing", v=1e-3, x=0.0)
    rate, margin, reversal = importer["slope"]
    assert (rate > 0.0, margin > 0.0) == (True, True)
    assert reversal == 1e-3
    force = importer.call("flowing", v=-1e-3, x=0.0)
    assert importer["slope"][2] == -1e-3
    assert math.isfinite(force)
    still = importer.call("flowing", v=0.0, x=0.0)
    assert importer["slope"][0] == pytest.approx(0.0, abs=1e-12)
    assert still == pytest.approx(2e6 * 1e-6)


def test_within_a_window_around_an_event_only_a_fast_motion_reverses():
    importer = Importer.moving(LUGRE)
    distance = importer.exchange.varying["z"].nominal
    lifted = []
    for moved in (0.0, 0.5e-6, 1e-6, 2e-6):  # of the distance before sliding
        importer["varying"][0] = moved * distance
        importer.call("flowing", v=-1e-3, x=0.0)
        lifted.append(importer["slope"][2] + 1e-3)
    assert lifted == pytest.approx([1e3 * distance, 0.5e3 * distance, 0.0, 0.0], abs=1e-9)


def test_margins_have_a_small_offset_beyond_their_events():
    importer = Importer.moving(NESTED)
    component = NESTED.component
    piece = component.piece(component.State(), importer["memory"], Motion(1e-3, 0.0), NESTED.parameters)
    _, _, margin = component.flow(*piece, Motion(1e-3, 0.0), NESTED.parameters)
    importer.call("flowing", v=1e-3, x=0.0)
    assert importer["slope"][-2] == pytest.approx(margin + BEYOND, rel=1e-15)
    assert 0.0 < BEYOND < 1e-6


def test_constant_whole_numbers_have_one_value_more_than_storable_turns():
    importer = Importer(NESTED)
    fields = [name for name, _ in zip(importer.exchange.flowing.source.__globals__["Piece"]._fields, importer.exchange.held, strict=False)]
    counts = {name: most for name, most in zip(fields, importer.exchange.held, strict=False) if most}
    assert list(counts.values()) == [importer["memory"].size // 2 + 1]
    assert len(importer.exchange.held) == len(fields) + 1  # the contact as it was at the event, a real number
    assert importer.exchange.held[-1] == 0


def test_an_event_commits_the_present_state_of_the_contact():
    importer = Importer.moving(NESTED)
    importer["varying"][0] = 2e-6
    importer.call("arrived")
    component, p = NESTED.component, NESTED.parameters
    memory = np.array(component.new_memory(p), dtype=float)
    contact, _ = component.piece(component.State(), memory, Motion(1e-3, 0.0), p)
    move = component.arrival(component.State(), memory, contact._replace(z=2e-6), p)
    after = component.commit(component.State(), memory, move, p)
    assert importer["lasting"].tolist() == [float(number) for number in after]
    assert importer["memory"].tolist() == memory.tolist()


@pytest.mark.parametrize("model", [LUGRE, NESTED], ids=lambda model: model.name)
def test_nominal_values_follow_from_half_the_largest_force_and_its_energy(model):
    varying = Importer(model, MASS).exchange.varying
    length, speed, largest = varying["x"].nominal, varying["v"].nominal, model.values["F_S"]
    force = br.response(model, np.linspace(0.0, 100.0 * length, 10_001), 1e6)  # slowly
    assert 0.5 * largest < force[100] < largest
    assert force[-1] == pytest.approx(largest, rel=1e-3)
    assert 2.5 * speed**2 == pytest.approx(largest * length, rel=1e-3)
    assert varying["z"].nominal == length
