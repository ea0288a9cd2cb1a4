{% if tolerance %}    printf("{{ name }}: deviation of %.2g of the largest {{ result }}\n", worst / {{ largest }});
    if (!(worst <= {{ tolerance }} * {{ largest }})) {
        return fails("the deviation exceeds the error of single precision");
    }
{% else %}    if (hash != UINT64_C({{ hash }})) {
        printf("expected {{ hash_text }}, last {{ result }} %.17g\n", expected_last);
        return fails("results differ: compile with -ffp-contract=off");
    }
{% endif %}