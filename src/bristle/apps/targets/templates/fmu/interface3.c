typedef struct {
    Situation now;
    Situation before;
    fmi3LogMessageCallback logger;
    fmi3InstanceEnvironment environment;
    bool logging;
{% if fmi == 2 %}    char name[64];
{% endif %}} Instance;

static fmi3Status answer(const Instance *instance, const char *problem)
{
    if (!problem) {
        return fmi3OK;
    }
    if (instance->logging && instance->logger) {
        instance->logger(instance->environment, {% if fmi == 2 %}instance->name, {% endif %}fmi3Error, "logStatusError", problem);
    }
    return fmi3Error;
}

{% if fmi == 2 %}const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

{% endif %}const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[])
{
    (void)nCategories;
    (void)categories;
    ((Instance *)instance)->logging = loggingOn;
    return fmi3OK;
}

static Instance *made(fmi3String token, bool exchanged, fmi3Boolean loggingOn, fmi3InstanceEnvironment environment,
                      fmi3LogMessageCallback logger)
{
    if (!token || strcmp(token, TOKEN) != 0) {
        return NULL;
    }
    Instance *instance = malloc(sizeof *instance);
    if (instance) {
        begin_anew(&instance->now);
{% if exchange %}        instance->now.exchanged = exchanged;
{% else %}        (void)exchanged;
{% endif %}        instance->logger = logger;
        instance->environment = environment;
        instance->logging = loggingOn;
    }
    return instance;
}

{% if fmi == 2 %}fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn)
{
    (void)fmuResourceLocation;
    (void)visible;
{% if not exchange %}    if (fmuType != fmi2CoSimulation) {
        return NULL;
    }
{% endif %}    Instance *instance = made(fmuGUID, fmuType == fmi2ModelExchange, loggingOn,
                              functions ? functions->componentEnvironment : NULL, functions ? functions->logger : NULL);
    if (instance) {
        memset(instance->name, 0, sizeof instance->name);
        for (size_t i = 0; instanceName && instanceName[i] && i + 1U < sizeof instance->name; ++i) {
            instance->name[i] = instanceName[i];
        }
    }
    return instance;
}
{% else %}fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
    const fmi3ValueReference requiredIntermediateVariables[], size_t nRequiredIntermediateVariables,
    fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
    fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)instanceName;
    (void)resourcePath;
    (void)visible;
    (void)eventModeUsed;
    (void)earlyReturnAllowed;
    (void)requiredIntermediateVariables;
    (void)nRequiredIntermediateVariables;
    (void)intermediateUpdate;
    return made(instantiationToken, false, loggingOn, instanceEnvironment, logMessage);
}
{% endif %}
void fmi3FreeInstance(fmi3Instance instance)
{
    free(instance);
}

{% if fmi == 2 %}fmi2Status fmi2EnterInitializationMode(fmi2Component instance)
{
    Situation *now = &((Instance *)instance)->now;
    if (now->phase != CREATED) {
        return answer(instance, "the instance was started before");
    }
    now->phase = STARTING;
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component instance, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{% else %}fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{% endif %}{
    Situation *now = &((Instance *)instance)->now;
    (void)toleranceDefined;
    (void)tolerance;
    (void)stopTimeDefined;
    (void)stopTime;
    if (now->phase != CREATED || !is_finite(startTime)) {
        return answer(instance, "{% if fmi == 2 %}the experiment cannot be set up now, or its start{% else %}the instance was started before, or the start{% endif %} is not a number");
    }
    now->begin = startTime;
    now->values[0] = startTime;
{% if fmi == 3 %}    now->phase = STARTING;
{% endif %}    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    Situation *now = &((Instance *)instance)->now;
    if (now->phase != STARTING) {
        return answer(instance, "the instance is not in initialization mode");
    }
{% if exchange %}    if (now->exchanged) {
        begun(now);
    }
    now->phase = now->exchanged ? AT_EVENT : STEPPING;
{% else %}    now->phase = STEPPING;
{% endif %}    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    ((Instance *)instance)->now.phase = OVER;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    begin_anew(&((Instance *)instance)->now);
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float64 values[]{% if fmi == 3 %}, size_t nValues{% endif %})
{
    {% if not exchange %}const {% endif %}Instance *asked = instance;
{% if exchange %}    bool looked = false;
{% endif %}    for (size_t i = 0; i < nValueReferences; ++i) {
        if (valueReferences[i] >= VARIABLES{% if fmi == 3 %} || nValues != nValueReferences{% endif %}) {
            return answer(asked, "there is no variable with this value reference{% if fmi == 3 %}, or the buffer is too small{% endif %}");
        }
{% if exchange %}        if (!looked && (asked->now.exchanged || roles[valueReferences[i]] >= A_STATE)) {
            look(&asked->now);
            looked = true;
        }
{% endif %}        values[i] = asked->now.values[valueReferences[i]];
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float64 values[]{% if fmi == 3 %}, size_t nValues{% endif %})
{
{% if fmi == 3 %}    if (nValues != nValueReferences) {
        return answer(instance, "each variable has one value");
    }
{% endif %}    for (size_t i = 0; i < nValueReferences; ++i) {
        const char *problem = given(&((Instance *)instance)->now, valueReferences[i], values[i]);
        if (problem) {
            return answer(instance, problem);
        }
    }
    return fmi3OK;
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    Situation *copy = *FMUState ? *FMUState : malloc(sizeof *copy);
    if (!copy) {
        return answer(instance, "out of memory");
    }
    *copy = ((Instance *)instance)->now;
    *FMUState = copy;
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    if (!FMUState{% if exchange %} || ((const Situation *)FMUState)->exchanged != ((Instance *)instance)->now.exchanged{% endif %}) {
        return answer(instance, "there is no state{% if exchange %}, or it belongs to the other kind of simulation{% endif %}");
    }
    ((Instance *)instance)->now = *(const Situation *)FMUState;
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    (void)instance;
    free(*FMUState);
    *FMUState = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    (void)instance;
    (void)FMUState;
    *size = SAVED;
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[], size_t size)
{
    if (!FMUState || size < SAVED) {
        return answer(instance, "there is no state, or the buffer is too small");
    }
    save(FMUState, {% if fmi == 2 %}(unsigned char *){% endif %}serializedState);
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState)
{
    if (!handed_out(FMUState, {% if fmi == 2 %}(const unsigned char *){% endif %}serializedState, size)) {
        return answer(instance, "the bytes are damaged or of another FMU, or out of memory");
    }
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint{% if fmi == 3 %}, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime{% endif %})
{
    Situation *now = &((Instance *)instance)->now;
    (void)noSetFMUStatePriorToCurrentPoint;
{% if fmi == 3 %}    *eventHandlingNeeded = fmi3False;
    *terminateSimulation = fmi3False;
    *earlyReturn = fmi3False;
{% endif %}{% if plant %}    const double failed = now->lasting[{{ failures_at }}];
{% endif %}    const char *problem = gone_on(now, &((Instance *)instance)->before, currentCommunicationPoint + communicationStepSize);
{% if fmi == 3 %}    *lastSuccessfulTime = now->values[0];
{% endif %}{% if plant %}    if (!problem && now->lasting[{{ failures_at }}] > failed) {
        return fmi3Warning;
    }
{% endif %}    return answer(instance, problem);
}
{% if fmi == 2 %}
fmi2Status fmi2GetRealStatus(fmi2Component instance, const fmi2StatusKind s, fmi2Real *value)
{
    if (s != fmi2LastSuccessfulTime) {
        return fmi2Discard;
    }
    *value = ((Instance *)instance)->now.values[0];
    return fmi2OK;
}
{% endif %}{% if exchange %}{% include "fmu/exchange_interface.c" %}{% endif %}