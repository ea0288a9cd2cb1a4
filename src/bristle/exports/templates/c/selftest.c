/* Self-test of {{ name }}: a walk of {{ count }} steps through pre-sliding and sliding. It compares the {% if tolerance %}forces with
   those of bristle {{ version }} in Python with double precision.{% else %}hash of the
   forces with that of bristle {{ version }} in Python: results must be identical.{% endif %} Prints the hash; exit code 0 or 1. */

#include "{{ name }}.h"

#include <stdio.h>

#define COUNT {{ count }}

{% include "c/hashed.c" %}int main(void)
{
    static const double scales[{{ scales | length }}] = { {{- scales | join(', ') -}} };
    static {{ name }} axis, copy;
    static unsigned char saved[{{ guard }}_SAVED];
{% if not operator %}    const double dt = {{ dt }};
{% endif %}{% if derived %}    /* Two directions: all parameters change, and the walk grows. */
    static const double change[{{ guard }}_PARAMETERS] = { {{- directions_of_test | join(', ') -}} };
    static {{ name }} axis_d;
    static {{ name }}_tangent d[2];
    uint64_t hash_d = UINT64_C(0xCBF29CE484222325);
    {{ name }}_start(&axis_d);
    {{ name }}_start_d(&d[0]);
    {{ name }}_start_d(&d[1]);
    for (unsigned i = 0; i < {{ guard }}_PARAMETERS; ++i) {
        d[0].parameters[i] = change[i];
    }
{% endif %}{% include "c/expected.c" %}    uint64_t hash = UINT64_C(0xCBF29CE484222325);
{% if feed %}    uint64_t feed_hash = UINT64_C(0xCBF29CE484222325);
{% endif %}    uint32_t bits = {{ seed }}U;
    double x = 0.0, force = 0.0;
    {{ name }}_start(&axis);
    for (unsigned k = 0; k < COUNT; ++k) {
        if (k > 0U) {
            bits = bits * {{ factor }}U + {{ term }}U;
            if ((bits >> 8U) % {{ rests }}U != 0U) {
                x = x + ((double)(bits >> 16U) - 32768.0) * scales[(k / {{ part }}U) % {{ scales | length }}U];
            }
        }
{% if feed %}        feed_hash = hashed(feed_hash, {{ name }}_feed(&axis, x, dt) + 0.0); /* zeros without a sign */
        force = axis.force;
{% else %}        force = {% if operator %}{{ name }}_output(&axis, x){% else %}{{ name }}_force(&axis, x, dt){% endif %};
{% endif %}        hash = hashed(hash, force);
{% include "c/missed.c" %}{% if derived %}        const double d_x[2] = {0.0, x};
        double slopes[2];
        if ({{ name }}_force_d(&axis_d, d, 2U, x, d_x, dt, NULL, {% for value in usual_signals %}{{ value }}, NULL, {% endfor %}slopes) != force) {
            return fails("the force with derivatives differs");
        }
        hash_d = hashed(hashed(hash_d, slopes[0] + 0.0), slopes[1] + 0.0); /* zeros without a sign */
{% endif %}        if (k == COUNT / 2U) {
            {{ name }}_save(&axis, saved);
            {{ name }}_start(&copy);
            if (!{{ name }}_load(&copy, saved, sizeof saved)) {
                return fails("the saved state is refused");
            }
        } else if (k > COUNT / 2U && {% if operator %}{{ name }}_output(&copy, x){% else %}{{ name }}_force(&copy, x, dt){% endif %} != force) {
            return fails("the restored state continues differently");
        }
    }
    printf("{{ name }}: hash %08lx%08lx, last force %.17g\n", (unsigned long)(hash >> 32U),
           (unsigned long)(hash & UINT64_C(0xFFFFFFFF)), force);
{% include "c/judged.c" %}{% if feed and not tolerance %}    if (feed_hash != UINT64_C({{ feed_hash }})) {
        return fails("the feed differs");
    }
{% endif %}{% if derived %}    if (hash_d != UINT64_C({{ hash_d }})) {
        return fails("derivatives differ");
    }
{% endif %}    if ({% if operator %}{{ name }}_output(&axis, force / (force - force)){% else %}{{ name }}_force(&axis, force / (force - force), dt){% endif %} != force || (axis.flags & {{ guard }}_REFUSED) == 0) {
        return fails("a position that is not a number is accepted");
    }
    saved[sizeof saved / 2U] ^= 4U;
    if ({{ name }}_load(&copy, saved, sizeof saved)) {
        return fails("damaged bytes are accepted");
    }
    printf("{{ name }}: {% if tolerance %}matches bristle within single precision{% else %}identical to bristle{% endif %}\n");
    return 0;
}
