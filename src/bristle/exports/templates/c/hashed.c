static uint64_t hashed(uint64_t value, double result)
{
    const union { double number; uint64_t bits; } both = {result};
    for (unsigned i = 0; i < 8U; ++i) {
        value = (value ^ ((both.bits >> (8U * i)) & 255U)) * UINT64_C(0x100000001B3);
    }
    return value;
}

static int fails(const char *what)
{
    printf("{{ name }}: %s\n", what);
    return 1;
}

