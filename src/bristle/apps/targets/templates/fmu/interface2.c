{# The functions of FMI 3.0 under their names in FMI 2.0. -#}
{% filter replace("fmi3Instance", "fmi2Component")
    | replace("fmi3LogMessageCallback", "fmi2CallbackLogger")
    | replace("fmi3Deserialize", "fmi2DeSerialize")
    | replace("GetContinuousStateDerivatives", "GetDerivatives")
    | replace("Float64", "Real")
    | replace("FMUState", "FMUstate")
    | replace("fmi3", "fmi2") %}{% include "fmu/interface3.c" %}{% endfilter %}