{% if parameters %}
/* Parameters that can change between two calls; `{{ name }}_start` sets the exported values. */
typedef struct {
{% for line in parameters %}    {{ line }}
{% endfor %}} {{ name }}_parameters;
{% endif %}
