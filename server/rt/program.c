/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "rt/program.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/capability.h>
#include <malloc.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "rt/memory.h"

/* Bytes: the largest block, and all at the heap's end, that malloc is told to keep; by how much the
 * heap grows at first; all three as malloc has them; what makes the heap grow. */
enum { KEPT_BLOCK = 32 << 20, KEPT_END = 1 << 30, SETUP_GROWTH = 64 << 20 };
enum { USUAL_SIZE = 128 << 10, FIRST_BLOCK = 1 << 20 };

void ss_program_begin_setup(void)
{
    (void)mallopt(M_MMAP_THRESHOLD, KEPT_BLOCK);
    (void)mallopt(M_TRIM_THRESHOLD, KEPT_END);
    (void)mallopt(M_TOP_PAD, SETUP_GROWTH);
    char *first = malloc(FIRST_BLOCK), *end = sbrk(0);
    /* Else malloc has no heap. */
    if (first != NULL && (uintptr_t)first < (uintptr_t)end) {
        ss_memory_ask_large_pages(first, (size_t)(end - first));
    }
    free(first);
}

void ss_program_end_setup(void)
{
    (void)mallopt(M_MMAP_THRESHOLD, USUAL_SIZE);
    (void)mallopt(M_TRIM_THRESHOLD, USUAL_SIZE);
    (void)mallopt(M_TOP_PAD, USUAL_SIZE);
    (void)malloc_trim(0);
    /* The kernel would go on joining pages, those that loops use, which then fault. */
    (void)prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0);
}

void ss_program_begin(void)
{
    for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; ++descriptor) {
        if (fcntl(descriptor, F_GETFD) < 0 && errno == EBADF) {
            /* The lowest free number is this one: those below are open by now. For reading: what
             * is printed there must fail, not vanish. */
            const int opened = open("/dev/null", O_RDONLY);
            (void)opened;
        }
    }
    signal(SIGXFSZ, SIG_IGN);
}

int ss_program_finish(const char *program, int status)
{
    errno = 0;
    if (fflush(stdout) == 0 && ferror(stdout) == 0) {
        return status;
    }
    const char *slash = strrchr(program, '/');
    fprintf(stderr, "%s: cannot write to stdout: %s\n", slash != NULL ? slash + 1 : program,
            errno != 0 ? strerror(errno) : "is the disk full, or stdout closed?");
    return status != 0 ? status : 1;
}

bool ss_program_can_tell(void)
{
    struct pollfd out = {.fd = STDERR_FILENO, .events = POLLOUT};
    return poll(&out, 1, 0) > 0;
}

void ss_program_stop_signals(sigset_t *out_signals)
{
    struct sigaction hangup;
    sigemptyset(out_signals);
    sigaddset(out_signals, SIGINT);
    sigaddset(out_signals, SIGTERM);
    if (sigaction(SIGHUP, NULL, &hangup) == 0 && hangup.sa_handler != SIG_IGN) {
        sigaddset(out_signals, SIGHUP);
    }
}

/* ---- capabilities ---- */

static bool raise_limit(__rlimit_resource_t limit, rlim_t value)
{
    const struct rlimit wanted = {value, value};
    return setrlimit(limit, &wanted) == 0;
}

void ss_program_drop_capabilities(bool reads_files)
{
    struct __user_cap_header_struct head = {.version = _LINUX_CAPABILITY_VERSION_3};
    struct __user_cap_data_struct data[_LINUX_CAPABILITY_U32S_3];
    if (syscall(SYS_capget, &head, data) != 0 || (data[0].permitted | data[1].permitted) == 0) {
        return;
    }
    /* What a first call raised may be set again later. */
    const bool has_limits =
        raise_limit(RLIMIT_MEMLOCK, RLIM_INFINITY) && raise_limit(RLIMIT_RTPRIO, 99);
    uint32_t kept = has_limits ? 0 : CAP_TO_MASK(CAP_SYS_NICE) | CAP_TO_MASK(CAP_IPC_LOCK);
    kept |= reads_files ? CAP_TO_MASK(CAP_DAC_READ_SEARCH) : 0;
    data[0].permitted &= kept;
    data[0].effective = data[0].permitted;
    data[0].inheritable = 0;
    data[1] = (struct __user_cap_data_struct){0};
    (void)syscall(SYS_capset, &head, data);
    /* A helper that is started gets back no more, though its user is root. */
    (void)prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
}
