{% if parameters %}
/* Parameters that may be changed between two calls; `{{ name }}_start` sets those that were exported. */
typedef struct {
{% for line in parameters %}    {{ line }}
{% endfor %}} {{ name }}_parameters;
{% endif %}
