#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0
#error "numbers must be rounded after every operation: use SSE2 or NEON, not the x87 unit"
#endif
#ifdef __FAST_MATH__
#error "-ffast-math gives other numbers: leave it out"
#endif

