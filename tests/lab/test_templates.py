"""Templates of a page, and what a model is called on it."""

from typing import NamedTuple

import jinja2
import pytest

from bristle.core import FrictionModel
from bristle.exports.page.described import head_of
from bristle.friction import find
from bristle.lab.page import environment


class Nothing(NamedTuple):
    """No parameters and no state."""


def trial(state, memory, motion, dt, p):
    return 0.0, state


def test_lines_of_a_template_that_are_no_text_leave_no_line_and_no_space():
    template = environment().from_string("<ul>\n  {% for word in words %}\n<li>{{ word }}</li>\n  {% endfor %}\n</ul>\n")
    assert template.render(words=["a", "<b>"]) == "<ul>\n<li>a</li>\n<li>&lt;b&gt;</li>\n</ul>"
    with pytest.raises(jinja2.UndefinedError):
        environment().from_string("{{ missing }}").render()


def test_a_model_of_a_file_is_called_by_its_file_and_a_model_of_the_package_by_its_name():
    own = FrictionModel(name="own", description="", Parameters=Nothing, State=Nothing, trial=trial, commit=lambda state, *_: state)
    assert head_of(own) == {"toml": 'file = "test_templates.py"', "python": ""}
    assert head_of(find("lugre+asymmetry")) == {"toml": 'model = "lugre+asymmetry"', "python": 'br.friction.find("lugre+asymmetry")'}
