{% if tolerance %}    printf("{{ name }}: off by %.2g of the largest {{ result }}\n", worst / {{ largest }});
    if (!(worst <= {{ tolerance }} * {{ largest }})) {
        return fails("farther off than single precision explains");
    }
{% else %}    if (hash != UINT64_C({{ hash }})) {
        printf("expected {{ hash_text }}, last {{ result }} %.17g\n", expected_last);
        return fails("other bits: is -ffp-contract=off given?");
    }
{% endif %}