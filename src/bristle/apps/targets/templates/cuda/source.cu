/* {{ title }}, as lanes of a graphics processor: each thread simulates a separate axis with separate parameters.

   {{ description }}
{% for line in facts %}   {{ line | folded('   ') }}
{% endfor %}
   Written by bristle {{ version }}; do not edit, export again. Build with --fmad=false: fused multiply-add changes the
   last bits of the results. A C++ compiler without CUDA can also compile this file, for one lane at a time.

{{ table }} */

#if defined(__CUDACC_RTC__)
typedef int int32_t;
typedef long long int64_t;
typedef unsigned int uint32_t;
typedef unsigned long long uint64_t;
#define INT64_C(value) value##LL
#define UINT64_C(value) value##ULL
#define DBL_MAX 1.7976931348623157e308
#define INFINITY __longlong_as_double(0x7FF0000000000000LL)
#define NAN __longlong_as_double(0x7FF8000000000000LL)
#else
#include <float.h>
#include <math.h>
#include <stdint.h>
#endif
#if defined(__CUDACC__) || defined(__CUDACC_RTC__)
#define {{ guard }}_LANE ((int)(blockIdx.x * blockDim.x + threadIdx.x))
#else
#define __device__
#define __global__
static thread_local int {{ name }}_lane = 0;
#define {{ guard }}_LANE {{ name }}_lane
#endif

{% include "c/structure.h" %}
{{ helpers }}
{{ definitions }}
{{ data }}
{{ inline }} bool is_finite(double x)
{
    return x - x == 0.0;
}

{% include "c/steps.c" %}
/* Reset every lane. */
extern "C" __global__ void {{ name }}_start_lanes({{ name }} *axes, int lanes)
{
    const int lane = {{ guard }}_LANE;
    if (lane < lanes) {
        {{ name }}_start(&axes[lane]);
    }
}
{% if parameters %}
/* Give every lane its own parameters: `values` has {{ columns }} rows of `lanes` numbers, one for each of
   {{ name }}_parameters in its order. Call it after the start. */
extern "C" __global__ void {{ name }}_set_lanes({{ name }} *axes, int lanes, const double *values)
{
    const int lane = {{ guard }}_LANE;
    if (lane < lanes) {
        double *own = (double *)&axes[lane].parameters;
        for (int i = 0; i < {{ columns }}; ++i) {
            own[i] = values[i * lanes + lane];
        }
    }
}
{% endif %}
/* Move every lane along its own {% if operator %}inputs{% else %}positions{% endif %}: `x` and `{{ output }}` have `samples` rows of `lanes` numbers. A second call
   continues after the first, so that a simulator can make one sample per call. */
extern "C" __global__ void {{ name }}_{{ output }}_lanes(
    {{ name }} *axes, int lanes, int samples{% if not operator %}, double dt{% endif %}, const double *x, double *{{ output }})
{
    const int lane = {{ guard }}_LANE;
    if (lane < lanes) {
        {{ name }} axis = axes[lane];
        for (int k = 0; k < samples; ++k) {
            const long long at = (long long)k * lanes + lane;
            {{ output }}[at] = {% if operator %}{{ name }}_output(&axis, x[at]){% else %}{{ name }}_force(&axis, x[at], dt){% endif %};
        }
        axes[lane] = axis;
    }
}

static_assert(sizeof({{ name }}) == {{ bytes }}, "{{ bytes }} bytes of memory for each lane");
