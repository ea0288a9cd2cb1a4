{% include "c/head.c" %}{% include "c/steps.c" %}
{% include "c/saved.c" %}