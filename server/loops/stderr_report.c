/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "loops/stderr_report.h"

#include <stdio.h>

#include "rt/plain.h"
#include "rt/program.h"

static const int64_t VERDICT_LOG_NS = 10000000000; /* between two warnings of one verdict */

/* When the verdict gets to degraded or worse: once, until it was better in between. */
static void log_verdict(ss_stderr_report *report, const ss_judgement *judgement, int64_t now_ns)
{
    if (judgement->verdict < SOFTSIM_VERDICT_DEGRADED) {
        report->logged_verdict = SOFTSIM_VERDICT_GOOD;
        return;
    }
    if (judgement->verdict <= report->logged_verdict ||
        (judgement->verdict < SOFTSIM_VERDICT_FAULT && now_ns < report->next_verdict_log_ns)) {
        return;
    }
    ss_plain_print(stderr, "softsimd: warning: %s: %s\n", softsim_verdict_name(judgement->verdict),
                   judgement->reason);
    report->logged_verdict = judgement->verdict;
    report->next_verdict_log_ns = now_ns + VERDICT_LOG_NS;
}

/* Two servers on one prefix answer every pose twice. */
static void log_other_server(ss_stderr_report *report, const ss_judgement *judgement)
{
    if (judgement->other[0] != '\0' && !report->is_other_server_logged) {
        ss_plain_print(
            stderr,
            "softsimd: warning: another server answers on prefix %s: %s; clients let go while "
            "they hear both: stop one (where it was started, if it takes no commands), or give it "
            "another --prefix\n",
            report->prefix, judgement->other);
        report->is_other_server_logged = true;
    }
}

/* At most once a second: how many poses were refused since, by reason. */
static void log_refusals(ss_stderr_report *report, int64_t now_ns)
{
    if (now_ns < report->next_log_ns) {
        return;
    }
    report->next_log_ns = now_ns + 1000000000;
    ss_gate_counts counts;
    ss_gate_read(report->gate, &counts);
    int64_t total = 0;
    for (int i = 0; i < SOFTSIM_REFUSED_COUNT; ++i) {
        total += counts.refused[i];
    }
    if (total == report->logged_refusals) {
        return;
    }
    fprintf(stderr, "softsimd: warning: %lld messages refused so far:", (long long)total);
    for (int i = 0; i < SOFTSIM_REFUSED_COUNT; ++i) {
        if (counts.refused[i] > 0) {
            fprintf(stderr, " %s %lld", softsim_refusal_name(i), (long long)counts.refused[i]);
        }
    }
    fprintf(stderr, "\n");
    report->logged_refusals = total;
}

void ss_stderr_report_update(ss_stderr_report *report, const ss_judgement *judgement,
                             int64_t now_ns)
{
    if (!ss_program_can_tell()) {
        return;
    }
    log_refusals(report, now_ns);
    if (judgement) {
        log_verdict(report, judgement, now_ns);
        log_other_server(report, judgement);
    }
}
