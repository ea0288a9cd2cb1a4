component {{ name }} "{{ title }}, in place of a pid. Written by bristle {{ version }}.";
{% for input in inputs %}{% for name in pins_of[input.name] %}pin in float {{ name }} "{{ input.told }}, in units of scale{{ per.get(input.name, '') }}";
{% endfor %}{% endfor %}pin out float effort "command of an amplifier in torque mode, in units of effort-scale";
pin in bit enable "true while the axis is controlled; before, effort is 0 and the law waits for its start";
pin out bit fault "wrong period of the thread, or an input or the result was not a finite number: effort is 0 until enable is false";
param rw float scale = {{ scale }} "{{ unit_x }} for 1 unit of the positions";
param rw float effort_scale = {{ effort_scale }} "{{ unit_force }} for 1 unit of effort";
option singleton yes;
function _ fp "once in each cycle of a thread of {{ dt }} s";
license "BSD-3-Clause";
author "bristle {{ version }}";
;;
{% include "hal/macros.c" %}static {{ name }} held;
static int begun;

FUNCTION(_) {
    if (!enable || !begun) {
        {{ name }}_start(&held);
        fault = 0;
        begun = 1;
    }
    if (!enable || fault) {
        effort = 0.0;
        return;
    }
    const {{ name }}_inputs inputs = { {{- values -}} };
    const double command = {{ name }}_effort(&held, &inputs) / effort_scale;
    fault = held.flags != 0 || !is_finite(command) || period != {{ period_ns }};
    effort = fault ? 0.0 : command;
}
