/* {{ title }}

   {{ description }}
{% for line in facts %}   {{ line | folded('   ') }}
{% endfor %}
{{ table }} */
component {{ name }} "{{ title }}, fed forward along the commanded position. Written by bristle {{ version }}.";
pin in float reference "commanded position of the axis, in units of scale";
pin out float feed "friction times gain, in units of effort-scale: add it to the output of the controller";
pin in float gain = 0 "share of the friction in feed, from 0 to 1";
pin out float gain_now "present gain: it follows gain by slew";
pin out bit fault "an input or a result was not a finite number: gain-now falls to 0 until reset";
pin in bit reset "clear fault and the memory of the contact";
param rw float scale = {{ scale }} "{{ unit_x }} for 1 unit of reference";
param rw float effort_scale = {{ effort_scale }} "{{ unit_force }} for 1 unit of feed";
param rw float lead = {{ lead }} "s by which the effort has to precede the motion: delay and lag of the drive";
param rw float lead_max = {{ lead_max }} "s, upper bound of lead";
param rw float limit = {{ limit }} "largest size of feed, in units of effort-scale; 0 for no limit";
param rw float slew = 1 "largest change of gain-now in 1 s";
param rw float clock = 1 "for tests: seconds of the axis in a second of the thread";
option singleton yes;
function _ fp "once in each cycle of the servo thread";
license "BSD-3-Clause";
author "bristle {{ version }}";
;;
{% include "hal/macros.c" %}static {{ name }} contact;
static double last_x, last_v, last_t, rate;
static int begun;

FUNCTION(_) {
    const double t = (double)period * 1e-9 * clock, x = reference * scale;
    if (!begun || reset) {
        {{ name }}_start(&contact);
        last_x = x;
        last_v = 0.0;
        begun = 1;
    }
    if (t != last_t) {
        last_t = t;
        rate = 1.0 / t;
    }
    const double v = (x - last_x) * rate, a = (v - last_v) * rate;
    const double asked = lead, longest = lead_max, bounded = asked < longest ? asked : longest, l = bounded > 0.0 ? bounded : 0.0;
    const double ahead = x + v * l + 0.5 * a * l * l;
    const double effort = {{ name }}_feed(&contact, ahead, t){{ effort_of_place }};
    if (is_finite(a)) {
        last_x = x;
        last_v = v;
    }
    const bool faulty = contact.flags != 0 || !is_finite(effort);
    const double share = gain, wish = faulty || !(share > 0.0) ? 0.0 : share < 1.0 ? share : 1.0, most = slew * t;
    const double before = gain_now, rise = wish - before, now = rise > most ? before + most : rise < -most ? before - most : wish;
    const double fed = now * effort / effort_scale, bound = limit;
    fault = faulty;
    gain_now = now;
    if (is_finite(fed)) {
        feed = bound > 0.0 && fed > bound ? bound : bound > 0.0 && fed < -bound ? -bound : fed;
    }
}
