
fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    Instance *instance = c;
    if (instance->now.phase != FLOWING) {
        return answer(instance, "not in continuous-time mode");
    }
    instance->now.phase = AT_EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *fmi2eventInfo)
{
    Instance *instance = c;
    if (instance->now.phase != AT_EVENT) {
        return answer(instance, "not in event mode");
    }
    turned(&instance->now);
    fmi2eventInfo->newDiscreteStatesNeeded = fmi2False;
    fmi2eventInfo->terminateSimulation = fmi2False;
    fmi2eventInfo->nominalsOfContinuousStatesChanged = fmi2False;
    fmi2eventInfo->valuesOfContinuousStatesChanged = fmi2False;
    fmi2eventInfo->nextEventTimeDefined = fmi2False;
    fmi2eventInfo->nextEventTime = 0.0;
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    Instance *instance = c;
    if (instance->now.phase != AT_EVENT) {
        return answer(instance, "not in event mode");
    }
    instance->now.phase = FLOWING;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation)
{
    (void)c;
    (void)noSetFMUStatePriorToCurrentPoint;
    *enterEventMode = fmi2False;
    *terminateSimulation = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    Instance *instance = c;
    if (!instance->now.exchanged || !is_finite(time)) {
        return answer(instance, "time cannot be set, or is not a number");
    }
    instance->now.values[0] = time;
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    return answer(c, moved(&((Instance *)c)->now, x, nx));
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    Instance *instance = c;
    if (!instance->now.exchanged || nx != VARYING) {
        return answer(instance, "no model exchange, or wrong number of states");
    }
    ready(&instance->now);
    memcpy(x, instance->now.varying, sizeof instance->now.varying);
    return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    if (nx != VARYING) {
        return answer(c, "no model exchange, or wrong number of states");
    }
    memcpy(x_nominal, nominals, sizeof nominals);
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    Instance *instance = c;
    double slope[VARYING + 2U];
    if (!instance->now.exchanged || nx != VARYING) {
        return answer(instance, "no model exchange, or wrong number of rates");
    }
    if (!has_rates(&instance->now, slope)) {
        return fmi2Discard;
    }
    memcpy(derivatives, slope, sizeof nominals);
    return fmi2OK;
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    Instance *instance = c;
    double slope[VARYING + 2U];
    if (!instance->now.exchanged || ni != MARGINS) {
        return answer(instance, "no model exchange, or wrong number of event indicators");
    }
    if (!has_rates(&instance->now, slope)) {
        return fmi2Discard;
    }
{% if exchange.margins %}    memcpy(eventIndicators, slope + VARYING, MARGINS * sizeof *slope);
{% else %}    (void)eventIndicators;
{% endif %}    return fmi2OK;
}
