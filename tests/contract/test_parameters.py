"""Parameters of every component of bristle: what is allowed, what is usual, what holds where nothing is said, and its example.

Models with a state divide by their forces and stiffnesses; a static map may have none. The examples of friction are of one
contact: 20 N of Coulomb and 28 N of static friction, 1e7 N/m before sliding. Those of operators are of micrometres and newtons.
"""

import pytest

from bristle import controllers, friction, hysteresis, plants, references, sensors

# Of each parameter its range or choices, its nominal value, whether it may differ by direction, its default and its example.
PARAMETERS = """
coulomb.F_C: 0..inf, 1, by direction, -, 20
viscous.F_v: 0..inf, 1, by direction, -, 200
coulomb_viscous.F_v: 0..inf, 1, by direction, -, 200
coulomb_viscous.F_C: 0..inf, 1, by direction, -, 20
stribeck.F_C: 0..inf, 1, by direction, -, 20
stribeck.F_S: 0..inf, 1, by direction, -, 28
stribeck.v_S: 1e-09..inf, 0.01, -, 0.002
stribeck.F_v: 0..inf, 1, by direction, -, 200
stribeck.delta_S: 0.1..10, 1, 2, -
stribeck_free.F_C: 0..inf, 1, by direction, -, 24
stribeck_free.F_0: 0..inf, 1, by direction, -, 18
stribeck_free.v_S: 1e-09..inf, 0.01, -, 0.002
stribeck_free.F_v: 0..inf, 1, by direction, -, 200
stribeck_free.delta_S: 0.1..10, 1, 2, -
dahl.sigma_0: 1e-09..inf, 1e+06, -, 1e+07
dahl.F_C: 1e-12..inf, 1, by direction, -, 20
dahl.sigma_2: 0..inf, 1, by direction, 0, 200
dahl.exponent: 0.1..5, 1, 1, 1.5
reformed_dahl.s: 1e-09..inf, 1e+06, -, 1e+07
reformed_dahl.f_p: 1e-12..inf, 1, by direction, -, 20
reformed_dahl.sigma_2: 0..inf, 1, by direction, 0, 200
bouc_wen.s: 1e-09..inf, 1e+06, -, 1e+07
bouc_wen.F_C: 1e-12..inf, 1, by direction, -, 20
bouc_wen.exponent: 1..20, 1, 2, 2
bouc_wen.beta: 0.5..1, 1, 0.5, 0.6
bouc_wen.alpha: 0..1, 1, 0, -
bouc_wen.sigma_2: 0..inf, 1, by direction, 0, 200
bouc_wen_classic.alpha: 1e-09..inf, 1e+06, -, 1e+07
bouc_wen_classic.gamma: -inf..inf, 1, -, 0.3
bouc_wen_classic.delta: -inf..inf, 1, -, 0.2
bouc_wen_classic.beta: 1e-12..inf, 1000, 1, 1e+06
bouc_wen_classic.nu: 1..20, 1, 1, -
bouc_wen_classic.sigma_2: 0..inf, 1, 0, 200
lugre.F_C: 1e-12..inf, 1, by direction, -, 20
lugre.F_S: 1e-12..inf, 1, by direction, -, 28
lugre.v_S: 1e-09..inf, 0.01, -, 0.002
lugre.sigma_0: 1e-09..inf, 1e+06, -, 1e+07
lugre.sigma_1: 0..inf, 100, 0, 1000
lugre.sigma_2: 0..inf, 1, by direction, 0, 200
lugre.v_d: 1e-12..inf, 1, inf, 0.05
elastoplastic.F_C: 1e-12..inf, 1, by direction, -, 20
elastoplastic.F_S: 1e-12..inf, 1, by direction, -, 28
elastoplastic.v_S: 1e-09..inf, 0.01, -, 0.002
elastoplastic.sigma_0: 1e-09..inf, 1e+06, -, 1e+07
elastoplastic.z_ba: 0..inf, 1e-06, -, 1.4e-06
elastoplastic.sigma_1: 0..inf, 100, 0, 1000
elastoplastic.sigma_2: 0..inf, 1, by direction, 0, 800
maxwell_slip.F_C: 1e-12..inf, 1, by direction, -, 20
maxwell_slip.k_i: 1e-09..inf, 1e+06, -, [6e+06 3e+06 1e+06]
maxwell_slip.nu_i: 0..1, 1, -, [0.3 0.4 0.3]
maxwell_slip.sigma_2: 0..inf, 1, by direction, 0, 200
maxwell_stribeck.F_C: 1e-12..inf, 1, by direction, -, 20
maxwell_stribeck.F_S: 1e-12..inf, 1, by direction, -, 28
maxwell_stribeck.v_S: 1e-09..inf, 0.01, -, 0.002
maxwell_stribeck.k_i: 1e-09..inf, 1e+06, -, [6e+06 3e+06 1e+06]
maxwell_stribeck.nu_i: 0..1, 1, -, [0.3 0.4 0.3]
maxwell_stribeck.sigma_1: 0..inf, 1, 0, 1000
maxwell_stribeck.sigma_2: 0..inf, 1, by direction, 0, 200
maxwell_stribeck.scatter: 0..0.3, 1, 0, 0.05
maxwell_stribeck.v_r: 0..inf, 1, 0, 1e-07
maxwell_stribeck.seed: 0..2.14748e+09, 1, 0, 1
gms.F_C: 1e-12..inf, 1, by direction, -, 20
gms.F_S: 1e-12..inf, 1, by direction, -, 28
gms.v_S: 1e-09..inf, 0.01, -, 0.002
gms.C: 1e-09..inf, 1000, -, 2000
gms.k_i: 1e-09..inf, 1e+06, -, [6e+06 3e+06 1e+06]
gms.nu_i: 0..1, 1, -, [0.3 0.4 0.3]
gms.sigma_2: 0..inf, 1, by direction, 0, 800
gap_slider.F_C: 0..inf, 1, by direction, -, 20
gap_slider.give: 1e-12..inf, 0.001, by direction, -, 4e-06
gap_slider.gap: 0..inf, 1, 0, 4e-06
gap_slider.n: 1..12, 2, 1, 2
gap_slider.share: 0..1, 0.1, 0, 0.1
gap_slider.sigma_2: 0..inf, 1, by direction, 0, 200
preisach_contact.s: 1e-09..inf, 1e+06, -, 1e+07
preisach_contact.f_p: 1e-12..inf, 1, -, 28
preisach_contact.sigma_2: 0..inf, 1, by direction, 0, 200
preisach_contact.kernel: dahl_masing|tip_masing|reformed_dahl_exact|exp_masing, 1, dahl_masing, -
preisach_contact.exponent: 0.1..5, 1, 2, -
preisach_contact.capacity: 4..100000, 1, 256, -
preisach_lugre.s: 1e-09..inf, 1e+06, -, 1e+07
preisach_lugre.f_p: 1e-12..inf, 1, -, 33.6
preisach_lugre.F_C: 1e-12..inf, 1, by direction, -, 20
preisach_lugre.F_S: 1e-12..inf, 1, by direction, -, 28
preisach_lugre.v_S: 1e-09..inf, 0.01, -, 0.002
preisach_lugre.sigma_1: 0..inf, 100, 0, 1000
preisach_lugre.sigma_2: 0..inf, 1, by direction, 0, 800
preisach_lugre.v_d: 1e-12..inf, 1, inf, -
preisach_lugre.kernel: dahl_masing|tip_masing|reformed_dahl_exact|exp_masing, 1, dahl_masing, -
preisach_lugre.exponent: 0.1..5, 1, 2, -
preisach_lugre.transition: paper|leuven|elastoplastic, 1, elastoplastic, -
preisach_lugre.n: 1..50, 1, 2, -
preisach_lugre.rho: 0..0.999, 1, 0.9, -
preisach_lugre.capacity: 4..100000, 1, 256, -
leuven.s: 1e-09..inf, 1e+06, -, 1e+07
leuven.f_p: 1e-12..inf, 1, -, 33.6
leuven.F_C: 1e-12..inf, 1, by direction, -, 20
leuven.F_S: 1e-12..inf, 1, by direction, -, 28
leuven.v_S: 1e-09..inf, 0.01, -, 0.002
leuven.sigma_1: 0..inf, 100, 0, 1000
leuven.sigma_2: 0..inf, 1, by direction, 0, 800
leuven.v_d: 1e-12..inf, 1, inf, -
leuven.kernel: dahl_masing|tip_masing|reformed_dahl_exact|exp_masing, 1, dahl_masing, -
leuven.exponent: 0.1..5, 1, 2, -
leuven.n: 1..50, 1, 2, 4
leuven.capacity: 4..100000, 1, 256, -
efficiency.mu_avg: -inf..inf, 0.1, -, 0.2
efficiency.mu_dif: -inf..inf, 0.01, -, 0.05
efficiency.h: 1e-12..inf, 0.001, -, 2e-06
efficiency.sigma_2: 0..inf, 1, by direction, 0, 200
efficiency.mu_fall: 0..inf, 0.1, 0, 0.1
efficiency.v_S: 1e-09..inf, 0.01, 0.01, 0.002
efficiency.F_idle: 0..inf, 1, 0, 20

play.r: 0..inf, 1, -, 1e-06
stop.r: 0..inf, 1, -, 1e-06
prandtl_ishlinskii.thresholds: 0..inf, 1, -, [1e-06 2e-06 5e-06]
prandtl_ishlinskii.weights: -inf..inf, 1e+06, -, [6e+06 3e+06 1e+06]
prandtl_ishlinskii.spring: -inf..inf, 1, 0, 100000
inverse_prandtl_ishlinskii.thresholds: 0..inf, 1, -, [10 13]
inverse_prandtl_ishlinskii.weights: -inf..inf, 1, -, [1.5e-07 6.7e-07]
inverse_prandtl_ishlinskii.compliance: -inf..inf, 1, 0, 1e-07
preisach.s: 1e-12..inf, 1e+06, -, 1.25e+07
preisach.f_p: 1e-12..inf, 1, -, 150
preisach.kernel: dahl_masing|tip_masing|reformed_dahl_exact|exp_masing, 1, dahl_masing, reformed_dahl_exact
preisach.exponent: 0.1..5, 1, 2, -
preisach.capacity: 4..inf, 1, 256, -
preisach.tolerance: 0..1, 1, 1e-12, -
inverse_preisach.s: 1e-12..inf, 1e+06, -, 1.25e+07
inverse_preisach.f_p: 1e-12..inf, 1, -, 150
inverse_preisach.kernel: dahl_masing|tip_masing|reformed_dahl_exact|exp_masing, 1, dahl_masing, dahl_masing
inverse_preisach.exponent: 0.1..5, 1, 2, -
inverse_preisach.capacity: 4..inf, 1, 256, -
inverse_preisach.tolerance: 0..1, 1, 1e-12, -
everett_table.extent: 1e-12..inf, 1e-05, -, 1e-05
everett_table.E: -inf..inf, 1, -, [0 6 10 0 6 10 0 6 10]
everett_table.upper: -inf..inf, 1, -, [0 3 5]
everett_table.capacity: 4..inf, 1, 256, -
everett_table.tolerance: 0..1, 1, 1e-12, -
preisach_grid.low: -inf..inf, 1, -, -1e-05
preisach_grid.high: -inf..inf, 1, -, 1e-05
preisach_grid.E: -inf..inf, 1, -, [3 4 2 6 5 3]
preisach_grid.offset: -inf..inf, 1, 0, -
preisach_grid.capacity: 4..inf, 1, 256, -
preisach_grid.tolerance: 0..1, 1, 1e-12, -
reversal_table.reversals: -inf..inf, 1, -, [-1e-05 0 1e-05]
reversal_table.ends: -inf..inf, 1, -, [6e-06 8e-06 1e-05]
reversal_table.E: -inf..inf, 1, -, [0 4 7 0 3 5 0 0 0]
reversal_table.E_top: -inf..inf, 1, -, [8 5.5 0]
reversal_table.side: -1..1, 1, 1, -
reversal_table.offset: -inf..inf, 1, 0, -
reversal_table.capacity: 4..inf, 1, 256, -
reversal_table.tolerance: 0..1, 1, 1e-12, -
relay_grid.levels: -inf..inf, 1, -, [-1e-06 0 1e-06]
relay_grid.weights: -inf..inf, 1, -, [3 -1 3]
inertia.M: 1e-15..inf, 1, -, -
oscillator.M: 1e-15..inf, 1, -, -
oscillator.c: 0..inf, 1, -, -
oscillator.k: 0..inf, 1, -, -
pulled_inertia.M: 1e-15..inf, 1, -, -
pulled_inertia.k: 0..inf, 1, -, -
pulled_inertia.v_e: -inf..inf, 1, -, -
ball_screw.J: 1e-15..inf, 1, -, 0.0001
ball_screw.M: 1e-09..inf, 10, -, 20
ball_screw.lead: 1e-06..inf, 0.005, -, 0.005
ball_screw.k: 1..inf, 1e+08, -, 1e+08
ball_screw.d: 0..inf, 1, 0, 2000
ball_screw.backlash: 0..inf, 1, 0, 0
cascade.k_p: 0..inf, 100, -, -
cascade.k_v: 0..inf, 100, -, -
cascade.k_i: 0..inf, 1, 0, -
cascade.k_ff: 0..2, 1, 0, -
cascade.limit: 0..inf, 1, inf, -
cascade.averaging: 1..2, 1, 1, -
sliding_mode.J: 0..inf, 1, -, -
sliding_mode.lambda_: 0..inf, 300, -, -
sliding_mode.K_1: 0..inf, 300, -, -
sliding_mode.K_2: 0..inf, 0.01, 0, -
sliding_mode.phi: 0..inf, 1, 0, -
sliding_mode.estimator: filtered_difference|tracking_observer, 1, filtered_difference, -
sliding_mode.cutoff: 0.001..inf, 1, inf, -
sliding_mode.limit: 0..inf, 1, inf, -
disturbance_observer.J: 0..inf, 1, -, -
disturbance_observer.lambda_: 0..inf, 300, -, -
disturbance_observer.K_1: 0..inf, 300, -, -
disturbance_observer.g: 0..inf, 60, -, -
disturbance_observer.estimator: filtered_difference|tracking_observer, 1, filtered_difference, -
disturbance_observer.cutoff: 0.001..inf, 1, inf, -
disturbance_observer.limit: 0..inf, 1, inf, -
super_twisting.J: 0..inf, 1, -, -
super_twisting.lambda_: 0..inf, 300, -, -
super_twisting.K_1: 0..inf, 300, -, -
super_twisting.k_1: 0..inf, 1, -, -
super_twisting.k_2: 0..inf, 1, -, -
super_twisting.estimator: filtered_difference|tracking_observer, 1, filtered_difference, -
super_twisting.cutoff: 0.001..inf, 1, inf, -
super_twisting.limit: 0..inf, 1, inf, -
lugre_observer.J: 0..inf, 1, -, -
lugre_observer.lambda_: 0..inf, 300, -, -
lugre_observer.K_1: 0..inf, 300, -, -
lugre_observer.F_C: 1e-12..inf, 1, -, -
lugre_observer.F_S: 1e-12..inf, 1, -, -
lugre_observer.v_S: 1e-12..inf, 1, -, -
lugre_observer.sigma_0: 0..inf, 1, -, -
lugre_observer.sigma_2: 0..inf, 1, 0, -
lugre_observer.k: 0..inf, 1, 0, -
lugre_observer.estimator: filtered_difference|tracking_observer, 1, filtered_difference, -
lugre_observer.cutoff: 0.001..inf, 1, inf, -
lugre_observer.limit: 0..inf, 1, inf, -
adaptive_hysteresis.J: 0..inf, 1, -, -
adaptive_hysteresis.lambda_: 0..inf, 300, -, -
adaptive_hysteresis.K_1: 0..inf, 300, -, -
adaptive_hysteresis.reach: 1e-12..inf, 1, -, -
adaptive_hysteresis.Gamma: 0..inf, 1, -, -
adaptive_hysteresis.w_max: 0..inf, 1, -, -
adaptive_hysteresis.delta: 0..inf, 1, 0, -
adaptive_hysteresis.estimator: filtered_difference|tracking_observer, 1, filtered_difference, -
adaptive_hysteresis.cutoff: 0.001..inf, 1, inf, -
adaptive_hysteresis.limit: 0..inf, 1, inf, -
adaptive_hysteresis.w_0: -inf..inf, 1, 0, -
adaptive_hysteresis.w_1: 0..inf, 1, 0, -
adaptive_hysteresis.w_2: 0..inf, 1, 0, -
adaptive_hysteresis.w_3: 0..inf, 1, 0, -
adaptive_hysteresis.w_4: 0..inf, 1, 0, -
adaptive_hysteresis.w_5: 0..inf, 1, 0, -
adaptive_hysteresis.w_6: 0..inf, 1, 0, -
asymptotic_observer.J: 1e-12..inf, 1, -, 100
asymptotic_observer.lambda_: 0..inf, 300, -, 150
asymptotic_observer.K_1: 0..inf, 300, -, 150
asymptotic_observer.g_1: 1e-09..inf, 60, -, 60
asymptotic_observer.g_2: 0..inf, 600, -, 400
asymptotic_observer.F_C: 1e-12..inf, 1, -, 10
asymptotic_observer.sigma_0: 0..inf, 1, -, 1e+06
asymptotic_observer.K_I: 0..inf, 1, 0, -
asymptotic_observer.band: 0..inf, 1, 0, -
asymptotic_observer.estimator: filtered_difference|tracking_observer, 1, filtered_difference, -
asymptotic_observer.cutoff: 0.001..inf, 1, inf, -
asymptotic_observer.limit: 0..inf, 1, inf, -
predictive_reversal.J: 0..inf, 1, -, -
predictive_reversal.lambda_: 0..inf, 300, -, -
predictive_reversal.K_1: 0..inf, 300, -, -
predictive_reversal.F_C: 0..inf, 1, -, -
predictive_reversal.F_S: 0..inf, 1, -, -
predictive_reversal.v_S: 1e-12..inf, 1, -, -
predictive_reversal.F_v: 0..inf, 1, 0, -
predictive_reversal.lead: 0..inf, 1, 0, -
predictive_reversal.x_0: 0..inf, 1, 0, -
predictive_reversal.estimator: filtered_difference|tracking_observer, 1, filtered_difference, -
predictive_reversal.cutoff: 0.001..inf, 1, inf, -
predictive_reversal.limit: 0..inf, 1, inf, -
encoder.resolution: 0..inf, 1e-07, 0, -
encoder.noise: 0..inf, 1, 0, -
encoder.seed: 0..2.14748e+09, 1, 0, -
recorded.position: -inf..inf, 1, -, -
recorded.sample_time: 1e-09..inf, 1, -, -
sine.amplitude: -inf..inf, 1, -, -
sine.frequency: 1e-09..inf, 1, -, -
sine.offset: -inf..inf, 1, 0, -
sine.ramp: 0..inf, 1, 0, -
varied_sine.amplitudes: -inf..inf, 1, -, -
varied_sine.frequency: 1e-09..inf, 1, -, -
varied_sine.duration: 1e-09..inf, 1, -, -
varied_sine.offset: -inf..inf, 1, 0, -
triangle.amplitude: -inf..inf, 1, -, 7e-06
triangle.velocity: 1e-12..inf, 1, -, 1e-05
triangle.acceleration: 1e-12..inf, 1, -, 0.001
triangle.jerk: 1e-12..inf, 1, inf, -
triangle.cycle_count: 1..1e+06, 1, 1, 2
triangle.ratio: 0.001..1000, 1, 1, -
s_curve.distance: -inf..inf, 1, -, 0.1
s_curve.velocity: 1e-12..inf, 1, -, 0.2
s_curve.acceleration: 1e-12..inf, 1, -, 2
s_curve.jerk: 1e-12..inf, 1, inf, 50
chirp.amplitude: -inf..inf, 1, -, 1e-06
chirp.f_0: 1e-09..inf, 1, -, 5
chirp.f_1: 1e-09..inf, 1, -, 100
chirp.duration: 1e-09..inf, 1, -, 5
chirp.ramp: 0..inf, 1, 0, 0.5
circle.radius: 1e-12..inf, 1, -, -
circle.feed: 1e-12..inf, 1, -, -
circle.axis: x|y, 1, x, -
circle.offset: -inf..inf, 1, 0, -
"""
FAMILIES = (
    *(friction.MODELS, hysteresis.OPERATORS, plants.PLANTS),
    *(controllers.CONTROLLERS, sensors.SENSORS, references.REFERENCES),
)
COMPONENTS = [component for family in FAMILIES for component in family.values()]


def number(value):
    return f"{value:.6g}" if isinstance(value, (int, float)) else str(value)


def told(value):
    return (
        f"[{' '.join(map(number, value))}]" if isinstance(value, (tuple, list)) else number(value)
    )


def line_of(component, name):
    variable = component.variables[name]
    allowed = (
        "|".join(variable.choices)
        if variable.choices
        else f"{number(variable.min)}..{number(variable.max)}"
    )
    sided = ", by direction" if variable.directional else ""
    known = [told(values.get(name, "-")) for values in (component.defaults, component.example)]
    return (
        f"{component.name}.{name}: {allowed}, {number(variable.nominal)}{sided}, {', '.join(known)}"
    )


@pytest.mark.parametrize("component", COMPONENTS, ids=lambda item: f"{item.family} {item.name}")
def test_parameters_have_their_range_nominal_value_default_and_example(component):
    expected = [line for line in PARAMETERS.splitlines() if line.startswith(f"{component.name}.")]
    assert [line_of(component, name) for name in component.variables] == expected


@pytest.mark.parametrize("component", COMPONENTS, ids=lambda item: f"{item.family} {item.name}")
def test_a_component_begins_at_zero_with_empty_integrals(component):
    state = (
        component.State()._asdict()
        if all(field in component.State._field_defaults for field in component.State._fields)
        else {}
    )
    assert {value for name, value in state.items() if name not in ("scale", "side")} <= {0.0}
