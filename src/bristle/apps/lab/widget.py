"""An interactive friction model in a notebook: a view of the lab with values shared by page and Python.

Scripts and module are those of the lab. The notebook adds a root element and traits: a slider sets the values in
Python, and Python moves the sliders.
"""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from bristle.apps.lab.page import PACKAGE
from bristle.apps.targets.page.described import values_of, widget_described
from bristle.core import InputError, MissingExtraError, Model, Variable, amount, guarded
from bristle.core.palette import DARK, LIGHT, colour_variables
from bristle.engine import FRICTION
from bristle.report.assets import joined

try:
    import anywidget
    import traitlets
except ImportError as error:
    raise MissingExtraError.of("a widget", "notebook") from error

SCRIPTS = ("physics.js", "paths.js", "plot.js", "controls.js", "views.js", "bench.js", "widget.js")
THEMES = "".join(
    f":host(.{theme}){{color-scheme:{theme};{''.join(f'--{name}:{colour};' for name, colour in colours.items())}}}"
    for theme, colours in (("light", LIGHT), ("dark", DARK))
)
STYLE = (
    colour_variables()
    + THEMES
    + joined(("lab.css", "controls.css", "widget.css"), PACKAGE)
    + joined(("card.css",), "bristle.report")
)


class Widget(anywidget.AnyWidget):
    """A view of a friction model: a slider for each parameter, its loops and its friction over velocity.

    Parameters
    ----------
    model : Model
        A friction model with parameters.
    uncertainty : mapping of str to mapping, optional
        For each parameter, a mapping with its ``interval`` (low, high) in SI, drawn under the slider.
    fastest : float
        Largest speed on the plot [m/s or rad/s]; 0 derives it from the model.

    Attributes
    ----------
    model : Model
        The present model, as a trait. A slider changes the model, and a change of the model moves the sliders. You may set
        another model.

    Raises
    ------
    InputError
        If `model` is not a friction model, or a page cannot compute the model.
    MissingExtraError
        If anywidget is not installed.

    Examples
    --------
    >>> from bristle import friction
    >>> widget = Widget(friction.coulomb_viscous(F_C="20 N", F_v="80 N*s/m"))
    >>> widget.parameters = {"F_C": "25 N"}
    >>> widget.model.F_C, widget.model.F_v
    (25.0, 80.0)
    """

    # The scripts of the lab, and the code that draws them in a notebook.
    _esm = f"{joined(SCRIPTS, PACKAGE)}\nconst STYLE = {json.dumps(STYLE)};\nexport {{ walked }};\nexport default {{ render }};\n"
    model = traitlets.Any()
    _described = traitlets.Dict().tag(sync=True)
    _values = traitlets.Dict().tag(sync=True)
    _problem = traitlets.Unicode().tag(sync=True)
    _card = traitlets.Unicode().tag(sync=True)  # HTML above the sliders

    @guarded(model=FRICTION, fastest=amount(Variable("length/time", "largest speed", min=0.0)))
    def __init__(
        self,
        model: Model,
        *,
        uncertainty: Mapping[str, Mapping[str, Any]] | None = None,
        fastest: float = 0.0,
    ) -> None:
        self._uncertainty, self._fastest = dict(uncertainty or {}), fastest
        super().__init__(model=model)

    @property
    def parameters(self) -> dict[str, Any]:
        """The parameters by name, in SI. Set some or all of them as numbers, or as text with units."""
        return dict(self.model.values)

    @parameters.setter
    def parameters(self, values: Mapping[str, Any]) -> None:
        self.model = self.model.with_values(**values)

    @traitlets.validate("model")
    def _only_friction(self, proposal: Any) -> Model:
        return FRICTION(proposal["value"], "model", None)

    @traitlets.observe("model")
    def _model_was_set(self, change: Any) -> None:
        before, model = change["old"], change["new"]
        alike = (
            isinstance(before, Model)
            and before.component is model.component
            and before.kind == model.kind
        )
        values = values_of(model)
        if not alike or {name: len(row) for name, row in values.items()} != {
            k: len(v) for k, v in self._values.items()
        }:
            uncertainty = None if isinstance(before, Model) else self._uncertainty
            facts = widget_described(model, uncertainty=uncertainty, fastest=self._fastest)
            with self.hold_sync():
                self._values, self._described = values, facts
        self._values, self._problem = values, ""

    @traitlets.observe("_values")
    def _values_came(self, change: Any) -> None:
        values = change["new"]
        if not self.trait_has_value("model") or values == values_of(self.model):
            return
        try:
            self.model = self.model.with_values(**_written(self.model, values))
        except InputError as error:
            # The sliders keep the values of the user and show the error; the model keeps its last valid values.
            self._problem = str(error)


def _written(model: Model, values: Mapping[str, Any]) -> dict[str, Any]:
    """Convert values from a page to those of a model."""
    rows: dict[str, Any] = {}
    for name, variable in model.component.variables.items():
        numbers = [float(number) for number in values[name]]
        if variable.choices:
            rows[name] = variable.choices[int(numbers[0])]
        elif np.ndim(model.values[name]):
            rows[name] = numbers
        else:
            rows[name] = int(numbers[0]) if model.component.is_integer(name) else numbers[0]
    return rows
