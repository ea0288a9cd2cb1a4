
{% if fmi == 3 %}fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage)
{
    (void)instanceName;
    (void)resourcePath;
    (void)visible;
    return made(instantiationToken, true, loggingOn, instanceEnvironment, logMessage);
}

{% endif %}fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    Situation *now = &((Instance *)instance)->now;
    if (now->phase != FLOWING) {
        return answer(instance, "not in continuous-time mode");
    }
    now->phase = AT_EVENT;
    return fmi3OK;
}

{% if fmi == 2 %}fmi2Status fmi2NewDiscreteStates(fmi2Component instance, fmi2EventInfo *fmi2eventInfo)
{% else %}fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime)
{% endif %}{
    Situation *now = &((Instance *)instance)->now;
    if (now->phase != AT_EVENT) {
        return answer(instance, "not in event mode");
    }
    turned(now);
{% if fmi == 2 %}    fmi2eventInfo->newDiscreteStatesNeeded = fmi2False;
    fmi2eventInfo->terminateSimulation = fmi2False;
    fmi2eventInfo->nominalsOfContinuousStatesChanged = fmi2False;
    fmi2eventInfo->valuesOfContinuousStatesChanged = fmi2False;
    fmi2eventInfo->nextEventTimeDefined = fmi2False;
    fmi2eventInfo->nextEventTime = 0.0;
{% else %}    *discreteStatesNeedUpdate = fmi3False;
    *terminateSimulation = fmi3False;
    *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = fmi3False;
    *nextEventTimeDefined = fmi3False;
    *nextEventTime = 0.0;
{% endif %}    return fmi3OK;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    Situation *now = &((Instance *)instance)->now;
    if (now->phase != AT_EVENT) {
        return answer(instance, "not in event mode");
    }
    now->phase = FLOWING;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation)
{
    (void)instance;
    (void)noSetFMUStatePriorToCurrentPoint;
    *enterEventMode = fmi3False;
    *terminateSimulation = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    Situation *now = &((Instance *)instance)->now;
    if (!now->exchanged || !is_finite(time)) {
        return answer(instance, "time cannot be set, or is not a number");
    }
    now->values[0] = time;
    return fmi3OK;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates)
{
    return answer(instance, moved(&((Instance *)instance)->now, continuousStates, nContinuousStates));
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    Situation *now = &((Instance *)instance)->now;
    if (!now->exchanged || nContinuousStates != VARYING) {
        return answer(instance, "no model exchange, or wrong number of states");
    }
    ready(now);
    memcpy(continuousStates, now->varying, sizeof now->varying);
    return fmi3OK;
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals_[], size_t nContinuousStates)
{
    if (nContinuousStates != VARYING) {
        return answer(instance, "no model exchange, or wrong number of states");
    }
    memcpy(nominals_, nominals, sizeof nominals);
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[],
                                             size_t nContinuousStates)
{
    Situation *now = &((Instance *)instance)->now;
    double slope[VARYING + 2U];
    if (!now->exchanged || nContinuousStates != VARYING) {
        return answer(instance, "no model exchange, or wrong number of rates");
    }
    if (!has_rates(now, slope)) {
        return fmi3Discard;
    }
    memcpy(derivatives, slope, sizeof nominals);
    return fmi3OK;
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[], size_t nEventIndicators)
{
    Situation *now = &((Instance *)instance)->now;
    double slope[VARYING + 2U];
    if (!now->exchanged || nEventIndicators != MARGINS) {
        return answer(instance, "no model exchange, or wrong number of event indicators");
    }
    if (!has_rates(now, slope)) {
        return fmi3Discard;
    }
{% if exchange.margins %}    memcpy(eventIndicators, slope + VARYING, MARGINS * sizeof *slope);
{% else %}    (void)eventIndicators;
{% endif %}    return fmi3OK;
}
{% if fmi == 3 %}
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates)
{
    (void)instance;
    *nContinuousStates = VARYING;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators)
{
    (void)instance;
    *nEventIndicators = MARGINS;
    return fmi3OK;
}
{% endif %}
fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],{% if fmi == 3 %} size_t nSeed,{% endif %}

                                        fmi3Float64 sensitivity[]{% if fmi == 3 %}, size_t nSensitivity{% endif %})
{
    Situation *now = &((Instance *)instance)->now;
    double direction[VARIABLES] = {0.0}, change[VARIABLES] = {0.0};
    if (!have_derivatives(now, unknowns, nUnknowns, knowns, nKnowns){% if fmi == 3 %} || nSeed != nKnowns || nSensitivity != nUnknowns{% endif %}) {
        return answer(instance, "derivatives exist in model exchange, by inputs and states");
    }
    for (size_t i = 0; i < nKnowns; ++i) {
        direction[knowns[i]] += seed[i];
    }
    changing(now, direction, change);
    for (size_t i = 0; i < nUnknowns; ++i) {
        sensitivity[i] = change[unknowns[i]];
    }
    return fmi3OK;
}
{% if fmi == 3 %}
fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                    fmi3Float64 sensitivity[], size_t nSensitivity)
{
    Situation *now = &((Instance *)instance)->now;
    if (!have_derivatives(now, unknowns, nUnknowns, knowns, nKnowns) || nSeed != nUnknowns || nSensitivity != nKnowns) {
        return answer(instance, "derivatives exist in model exchange, by inputs and states");
    }
    for (size_t k = 0; k < nKnowns; ++k) {
        double direction[VARIABLES] = {0.0}, change[VARIABLES] = {0.0};
        direction[knowns[k]] = 1.0;
        changing(now, direction, change);
        sensitivity[k] = 0.0;
        for (size_t i = 0; i < nUnknowns; ++i) {
            sensitivity[k] += seed[i] * change[unknowns[i]];
        }
    }
    return fmi3OK;
}
{% endif %}