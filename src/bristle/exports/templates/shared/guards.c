#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0
#error "every operation must round its result: use SSE2 or NEON, not the x87 unit"
#endif
#ifdef __FAST_MATH__
#error "-ffast-math changes the results: omit it"
#endif

