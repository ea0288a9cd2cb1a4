typedef struct {
    Situation now;
    Situation before;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    bool logging;
    char name[64];
} Instance;

static fmi2Status answer(const Instance *instance, const char *problem)
{
    if (!problem) {
        return fmi2OK;
    }
    if (instance->logging && instance->logger) {
        instance->logger(instance->environment, instance->name, fmi2Error, "logStatusError", problem);
    }
    return fmi2Error;
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories, const fmi2String categories[])
{
    (void)nCategories;
    (void)categories;
    ((Instance *)c)->logging = loggingOn != fmi2False;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn)
{
    (void)fmuResourceLocation;
    (void)visible;
    if ({% if not exchange %}fmuType != fmi2CoSimulation || {% endif %}!fmuGUID || strcmp(fmuGUID, TOKEN) != 0) {
        return NULL;
    }
    Instance *instance = malloc(sizeof *instance);
    if (instance) {
        begin_anew(&instance->now);
{% if exchange %}        instance->now.exchanged = fmuType == fmi2ModelExchange;
{% endif %}        instance->logger = functions ? functions->logger : NULL;
        instance->environment = functions ? functions->componentEnvironment : NULL;
        instance->logging = loggingOn != fmi2False;
        memset(instance->name, 0, sizeof instance->name);
        for (size_t i = 0; instanceName && instanceName[i] && i + 1U < sizeof instance->name; ++i) {
            instance->name[i] = instanceName[i];
        }
    }
    return instance;
}

void fmi2FreeInstance(fmi2Component c)
{
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    Instance *instance = c;
    (void)toleranceDefined;
    (void)tolerance;
    (void)stopTimeDefined;
    (void)stopTime;
    if (instance->now.phase != CREATED || !is_finite(startTime)) {
        return answer(instance, "the experiment cannot be set up now, or its start is not a number");
    }
    instance->now.begin = startTime;
    instance->now.values[0] = startTime;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    Instance *instance = c;
    if (instance->now.phase != CREATED) {
        return answer(instance, "the instance was started before");
    }
    instance->now.phase = STARTING;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    Instance *instance = c;
    if (instance->now.phase != STARTING) {
        return answer(instance, "the instance is not in initialization mode");
    }
{% if exchange %}    if (instance->now.exchanged) {
        begun(&instance->now);
    }
    instance->now.phase = instance->now.exchanged ? AT_EVENT : STEPPING;
{% else %}    instance->now.phase = STEPPING;
{% endif %}    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    ((Instance *)c)->now.phase = OVER;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    begin_anew(&((Instance *)c)->now);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    {% if not exchange %}const {% endif %}Instance *instance = c;
{% if exchange %}    bool looked = false;
{% endif %}    for (size_t i = 0; i < nvr; ++i) {
        if (vr[i] >= VARIABLES) {
            return answer(instance, "there is no variable with this value reference");
        }
{% if exchange %}        if (!looked && (instance->now.exchanged || roles[vr[i]] >= A_STATE)) {
            look(&instance->now);
            looked = true;
        }
{% endif %}        value[i] = instance->now.values[vr[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    Instance *instance = c;
    for (size_t i = 0; i < nvr; ++i) {
        const char *problem = given(&instance->now, vr[i], value[i]);
        if (problem) {
            return answer(instance, problem);
        }
    }
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    Situation *copy = *FMUstate ? *FMUstate : malloc(sizeof *copy);
    if (!copy) {
        return answer(c, "out of memory");
    }
    *copy = ((Instance *)c)->now;
    *FMUstate = copy;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    if (!FMUstate{% if exchange %} || ((const Situation *)FMUstate)->exchanged != ((Instance *)c)->now.exchanged{% endif %}) {
        return answer(c, "there is no state{% if exchange %}, or it belongs to the other kind of simulation{% endif %}");
    }
    ((Instance *)c)->now = *(const Situation *)FMUstate;
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    (void)c;
    free(*FMUstate);
    *FMUstate = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    (void)c;
    (void)FMUstate;
    *size = SAVED;
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size)
{
    if (!FMUstate || size < SAVED) {
        return answer(c, "there is no state, or the buffer is too small");
    }
    save(FMUstate, (unsigned char *)serializedState);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate)
{
    if (!handed_out(FMUstate, (const unsigned char *)serializedState, size)) {
        return answer(c, "the bytes are damaged or of another FMU, or out of memory");
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    Instance *instance = c;
    (void)noSetFMUStatePriorToCurrentPoint;
{% if plant %}    const double failed = instance->now.lasting[{{ failures_at }}];
{% endif %}    const char *problem = gone_on(&instance->now, &instance->before, currentCommunicationPoint + communicationStepSize);
{% if plant %}    if (!problem && instance->now.lasting[{{ failures_at }}] > failed) {
        return fmi2Warning;
    }
{% endif %}    return answer(instance, problem);
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    if (s != fmi2LastSuccessfulTime) {
        return fmi2Discard;
    }
    *value = ((Instance *)c)->now.values[0];
    return fmi2OK;
}
