static uint64_t digest(const unsigned char *bytes, size_t size)
{
    uint64_t value = UINT64_C(0xCBF29CE484222325);
    for (size_t i = 0; i < size; ++i) {
        value = (value ^ bytes[i]) * UINT64_C(0x100000001B3);
    }
    return value;
}

static unsigned char *put(unsigned char *at, uint64_t value)
{
    for (unsigned i = 0; i < 8U; ++i) {
        at[i] = (unsigned char)((value >> (8U * i)) & 255U);
    }
    return at + 8;
}

static uint64_t got(const unsigned char *at)
{
    uint64_t value = 0;
    for (unsigned i = 0; i < 8U; ++i) {
        value |= (uint64_t)at[i] << (8U * i);
    }
    return value;
}

