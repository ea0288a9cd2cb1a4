{% if tolerance %}        if (k % {{ every }}U == 0U) {
            const double miss = {{ result }} > expected[k / {{ every }}U] ? {{ result }} - expected[k / {{ every }}U] : expected[k / {{ every }}U] - {{ result }};
            worst = miss > worst ? miss : worst;
        }
{% endif %}