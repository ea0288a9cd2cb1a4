"""What turns red on the page is what the certificates of Python fail, with their numbers, wherever parameters stand."""

import json
from contextlib import suppress
from functools import cache

import numpy as np
import pytest
from tests.lab.scripts import needs_node, node

from bristle.certificates import certify, quasi_static
from bristle.core import InputError
from bristle.exports.page import described, packing
from bristle.friction import MODELS, unvaried, with_slots
from bristle.testing import example_of

pytestmark = needs_node
SLOTS = ("position", "periodic", "load", "temperature", "asymmetry")
FAST = ("coulomb", "bouc_wen", "maxwell_slip", "gms", "lugre", "elastoplastic")
# How near the numbers are: a force is looked for by another search than in Python, and closure shows it most.
CLOSE = ({"rel": 1e-5, "abs": 1e-15}, {"rel": 1e-3, "abs": 1e-9})
VARYING = ("p_1", "a_2", "c_1", "c_1_pos", "s_2_neg")
FACTORS = (0.3, 0.7, 1.0, 1.0, 1.5, 4.0)
CHOICES = [{"transition": name} for name in ("paper", "leuven", "elastoplastic")]
JUDGED = """
const contact = await loaded(models[0]);
const answers = [];
for (const given of CASES) {
  const values = Object.fromEntries(Object.entries(given).map(([name, each]) => [name, numbersOf(each)]));
  for (const [name, each] of Object.entries(values)) contact.set(name, each);
  const { drift, closure } = judged(contact);
  answers.push([drift, closure].map((answer) => answer && [answer.passed, answer.moved ?? answer.missing]));
  // After that everything is as it was.
  for (const [name, each] of Object.entries(values)) contact.set(name, each);
}
say(answers);
"""


@cache
def page_model(name, slots=()):
    return packing.plain(described.model_described(model_of(name, slots)))


def model_of(name, slots=()):
    return example_of(with_slots(MODELS[name], slots)) if slots else described.example_named(name)


def moved(model, count):
    """Return the model with its parameters somewhere else, where they are allowed."""
    random = np.random.default_rng(7)
    result = [model, *([model.with_values(**choice) for choice in CHOICES] if "transition" in model.values else [])]
    while len(result) < count:
        changes = {}
        for name, value in model.values.items():
            variable = model.component.variables[name]
            if name in VARYING:
                changes[name] = 0.1 if variable.quantity == "1" else 2.0
            elif isinstance(value, float) and np.isfinite(value) and value != 0.0 and variable.quantity != "1":
                changes[name] = value * float(random.choice(FACTORS))
        if "beta" in model.values:
            changes["beta"] = (0.5, 0.8, 1.0)[len(result) % 3]
        if (F_S := changes.get("F_S")) is not None and random.integers(3) == 0:
            changes["F_C"] = F_S  # where elements that slip give nothing back
        with suppress(InputError):
            result.append(model.with_values(**changes))
    return result


def of_python(model):
    """Return verdict and number of each certificate; None where it does not apply."""
    still = unvaried(model)
    holding = quasi_static.holding_of(still)
    answers = [certify.drift(still, holding, None, is_magnet=False), certify.closure(still, holding, None)]
    return [[each.passed, each.value] if each.applies else None for each in answers]


def coded(model):
    rows = {}
    for name, value in model.values.items():
        variable = model.component.variables[name]
        rows[name] = [float(x) for x in np.atleast_1d(variable.choices.index(value) if isinstance(value, str) else value)]
    return packing.plain(rows)


def compared(name, slots, count, folder):
    """Compare both, and return which verdicts there were."""
    models = moved(model_of(name, slots), count)
    answers = node(folder, [page_model(name, slots)], JUDGED.replace("CASES", json.dumps([coded(m) for m in models])))
    verdicts = [set(), set()]
    for model, answer in zip(models, answers, strict=True):
        for i, (custom, other) in enumerate(zip(answer, of_python(model), strict=True)):
            assert (custom is None) == (other is None), (model, i, custom, other)
            if custom is not None:
                verdicts[i].add(custom[0])
                assert custom[0] == other[0], (model, i, custom, other)
                assert custom[1] == pytest.approx(other[1], **CLOSE[i]), (model, i, custom, other)
    return verdicts


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("name", FAST)
def test_verdicts_and_numbers_are_those_of_the_certificates(name, tmp_path):
    compared(name, (), 5, tmp_path)


def test_variation_along_the_axis_is_judged_in_its_middle(tmp_path):
    compared("lugre", SLOTS, 2, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("slots", [(), SLOTS], ids=["plain", "slots"])
def test_verdicts_of_every_model_are_those_of_the_certificates(name, slots, tmp_path):
    verdicts = compared(name, slots, 16, tmp_path)
    if name == "preisach_lugre":
        assert verdicts[0] == verdicts[1] == {True, False}


def test_words_name_failed_and_inapplicable_certificates(tmp_path):
    script = """
    const texts = [];
    for (const model of models) {
      const contact = await loaded(model);
      texts.push(verdicts(model, judged(contact)).map(({ asked, passed, text }) => [asked, passed, text]));
    }
    say(texts);
    """
    film, gms, lugre = node(tmp_path, [page_model(name) for name in ("viscous", "gms", "lugre")], script)
    assert [[passed for _, passed, _ in lines] for lines in (film, gms, lugre)] == [[None] * 2, [True] * 2, [False] * 2]
    assert [words in text for words, (*_, text) in zip(("986\u00a0nm", "34.7 %"), lugre, strict=True)] == [True, True]
