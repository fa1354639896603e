/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * FMA peak: twelve independent chains of 8-lane (16-lane) fused multiply-adds, more than latency
 * (4) times ports (2), so that the units never wait. Bandwidth: the triad of STREAM (McCalpin 1995)
 * over three arrays that no cache holds. The best of several passes, by thread CPU time: a
 * neighbour on the machine then costs bandwidth, but not time that we did not run.
 */
#include "bench/core/yardstick.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "rt/clock.h"

enum {
    CHAINS = 12,
    LANES = 8,
    LANES_512 = 16,
    ROUNDS = 200000,
    PASSES = 7,
    TRIAD = 4 * 1024 * 1024
};

#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) static float run_chains_wide(void)
{
    __m256 chain[CHAINS];
    const __m256 factor = _mm256_set1_ps(0.999999f);
    const __m256 term = _mm256_set1_ps(1e-6f);
    for (int c = 0; c < CHAINS; ++c) {
        chain[c] = _mm256_set1_ps((float)c);
    }
    for (int round = 0; round < ROUNDS; ++round) {
        for (int c = 0; c < CHAINS; ++c) {
            chain[c] = _mm256_fmadd_ps(chain[c], factor, term);
        }
    }
    __m256 sum = _mm256_setzero_ps();
    for (int c = 0; c < CHAINS; ++c) {
        sum = _mm256_add_ps(sum, chain[c]);
    }
    return _mm256_cvtss_f32(sum);
}

__attribute__((target("avx512f"))) static float run_chains_512(void)
{
    __m512 chain[CHAINS];
    const __m512 factor = _mm512_set1_ps(0.999999f);
    const __m512 term = _mm512_set1_ps(1e-6f);
    for (int c = 0; c < CHAINS; ++c) {
        chain[c] = _mm512_set1_ps((float)c);
    }
    for (int round = 0; round < ROUNDS; ++round) {
        for (int c = 0; c < CHAINS; ++c) {
            chain[c] = _mm512_fmadd_ps(chain[c], factor, term);
        }
    }
    __m512 sum = _mm512_setzero_ps();
    for (int c = 0; c < CHAINS; ++c) {
        sum = _mm512_add_ps(sum, chain[c]);
    }
    return _mm512_cvtss_f32(sum);
}
#endif

static float run_chains_plain(void)
{
    float chain[CHAINS][LANES];
    for (int i = 0; i < CHAINS * LANES; ++i) {
        chain[i / LANES][i % LANES] = (float)i;
    }
    for (int round = 0; round < ROUNDS; ++round) {
        for (int c = 0; c < CHAINS; ++c) {
            for (int lane = 0; lane < LANES; ++lane) {
                chain[c][lane] = chain[c][lane] * 0.999999f + 1e-6f;
            }
        }
    }
    float sum = 0.0f;
    for (int i = 0; i < CHAINS * LANES; ++i) {
        sum += chain[i / LANES][i % LANES];
    }
    return sum;
}

static float run_chains(void)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
        return run_chains_wide();
    }
#endif
    return run_chains_plain();
}

static double measure_fma(float (*chains)(void), int lanes)
{
    volatile float kept = 0.0f;
    double best_s = INFINITY;
    for (int pass = 0; pass < PASSES; ++pass) {
        const int64_t start_ns = ss_clock_thread_cpu_ns();
        kept = chains();
        best_s = fmin(best_s, 1e-9 * (double)(ss_clock_thread_cpu_ns() - start_ns));
    }
    (void)kept;
    return best_s > 0.0 ? 2e-9 * CHAINS * lanes * (double)ROUNDS / best_s : 0.0;
}

static double measure_bandwidth(void)
{
    double *a = calloc(3 * (size_t)TRIAD, sizeof *a);
    if (a == NULL) {
        return 0.0;
    }
    double *b = a + TRIAD;
    double *c = b + TRIAD;
    for (int i = 0; i < TRIAD; ++i) {
        a[i] = 0.0;
        b[i] = i;
        c[i] = -i;
    }
    double best_s = INFINITY;
    volatile double scale = 3.0;
    for (int pass = 0; pass < PASSES; ++pass) {
        const double s = scale;
        const int64_t start_ns = ss_clock_thread_cpu_ns();
        for (int i = 0; i < TRIAD; ++i) {
            a[i] = b[i] + s * c[i];
        }
        best_s = fmin(best_s, 1e-9 * (double)(ss_clock_thread_cpu_ns() - start_ns));
        scale = a[TRIAD / 2] > 0.0 ? 2.0 : 3.0; /* the result is used: no pass is left out */
    }
    free(a);
    return best_s > 0.0 ? 24e-9 * TRIAD / best_s : 0.0;
}

static void read_processor(char *out, size_t size)
{
    char line[512];
    FILE *file = fopen("/proc/cpuinfo", "re");
    out[0] = '\0';
    while (file != NULL && out[0] == '\0' && fgets(line, sizeof line, file) != NULL) {
        const char *colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) == 0 && colon != NULL) {
            snprintf(out, size, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
        }
    }
    if (file != NULL) {
        fclose(file);
    }
}

void ss_yardstick_measure(ss_yardstick *out)
{
    memset(out, 0, sizeof *out);
    read_processor(out->processor, sizeof out->processor);
    struct utsname system;
    if (uname(&system) == 0) {
        snprintf(out->system, sizeof out->system, "%.40s %.50s", system.sysname, system.release);
    }
    out->cores = (int32_t)sysconf(_SC_NPROCESSORS_ONLN);
    double load = 0.0;
    out->load = getloadavg(&load, 1) == 1 ? load : 0.0;
    out->fma_gflops = measure_fma(run_chains, LANES);
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f")) {
        out->fma_512_gflops = measure_fma(run_chains_512, LANES_512);
    }
#endif
    out->bandwidth_gb_s = measure_bandwidth();
}
