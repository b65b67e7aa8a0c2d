#pragma once

/// Before a function whose loops gain from wider vectors than every x86-64 has: it is compiled again for AVX2 and for
/// AVX-512, and the program takes the one that the processor has. The results are the same to the last bit, since
/// nothing is fused (-ffp-contract=off) or summed in another order. Nothing elsewhere, and under sanitizers, whose
/// start-up it would precede.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define CPPLUS_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define CPPLUS_VECTOR_CLONES
#endif
