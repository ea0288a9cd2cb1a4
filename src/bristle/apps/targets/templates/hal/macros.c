/* Each operation rounds its result, on ARM also: no fused multiply-add. */
#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#else
#pragma GCC optimize("O3", "fp-contract=off")
#endif
{% for macro in macros %}#pragma push_macro("{{ macro }}")
#undef {{ macro }}
{% endfor %}
#include <stdint.h>

{{ code }}
{% for macro in macros %}#pragma pop_macro("{{ macro }}")
{% endfor %}
