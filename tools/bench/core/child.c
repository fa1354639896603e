/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/core/child.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "process.h"
#include "rt/clock.h"

static const int64_t look_ns = 5000000; /* between looks at a child that is to end */

/* In the child: `path`, or nowhere, becomes `fd`. */
static void redirect(int fd, const char *path)
{
    const int flags = path != NULL ? O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC : O_RDWR | O_CLOEXEC;
    const int file = open(path != NULL ? path : "/dev/null", flags, 0666);
    if (file < 0 || dup2(file, fd) < 0) {
        _exit(126);
    }
}

/* In the child: our handlers are not its own. What was sent since the fork ends it now. */
static void forget_handlers(const sigset_t *mask)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
        struct sigaction action;
        if (sigaction(numbers[i], NULL, &action) == 0 && action.sa_handler != SIG_IGN) {
            signal(numbers[i], SIG_DFL);
        }
    }
    sigprocmask(SIG_SETMASK, mask, NULL);
}

/* In the child, between fork and exec: system calls only. */
_Noreturn static void become(const ss_child_plan *plan, const int pipe_fd[2], pid_t parent,
                             const sigset_t *mask)
{
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    forget_handlers(mask);
    if (getppid() != parent) {
        _exit(126);
    }
    redirect(STDIN_FILENO, NULL);
    redirect(STDERR_FILENO, plan->err_path);
    if (plan->has_pipe) {
        if (dup2(pipe_fd[1], STDOUT_FILENO) < 0) {
            _exit(126);
        }
    } else {
        redirect(STDOUT_FILENO, plan->out_path);
    }
    if (plan->folder != NULL && chdir(plan->folder) != 0) {
        _exit(126);
    }
    /* execvp takes pointers to what it does not change. */
    union {
        const char *const *from;
        char *const *to;
    } argv = {.from = plan->argv};
    execvp(plan->argv[0], argv.to);
    _exit(127);
}

softsim_status ss_child_start(ss_child *child, const ss_child_plan *plan, softsim_error *error)
{
    int pipe_fd[2] = {-1, -1};
    *child = (ss_child){.name = plan->name, .out_fd = -1};
    if (plan->has_pipe && pipe2(pipe_fd, O_CLOEXEC) != 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "%s: %s", plan->name, strerror(errno));
        return SOFTSIM_ERROR_SYSTEM;
    }
    const pid_t parent = getpid();
    sigset_t stops, mask;
    sigemptyset(&stops);
    sigaddset(&stops, SIGINT);
    sigaddset(&stops, SIGTERM);
    sigaddset(&stops, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &stops, &mask); /* until the child has no handler of ours */
    child->pid = fork();
    if (child->pid == 0) {
        become(plan, pipe_fd, parent, &mask);
    }
    pthread_sigmask(SIG_SETMASK, &mask, NULL);
    if (pipe_fd[1] >= 0) {
        close(pipe_fd[1]);
    }
    if (child->pid < 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "%s: cannot start: %s", plan->name,
                          strerror(errno));
        if (pipe_fd[0] >= 0) {
            close(pipe_fd[0]);
        }
        return SOFTSIM_ERROR_SYSTEM;
    }
    child->out_fd = pipe_fd[0];
    child->is_running = true;
    return SOFTSIM_OK;
}

bool ss_child_wait_text(ss_child *child, const char *text, double timeout_s)
{
    const int64_t deadline_ns = ss_clock_now_ns() + (int64_t)(1e9 * timeout_s);
    char heard[4096] = "";
    size_t used = 0;
    while (strstr(heard, text) == NULL) {
        struct pollfd wait = {.fd = child->out_fd, .events = POLLIN};
        if (ss_process_is_stopped() || ss_clock_now_ns() >= deadline_ns) {
            return false;
        }
        if (poll(&wait, 1, 50) <= 0) {
            continue;
        }
        if (used > sizeof heard / 2) { /* keep the end: the text may be in two pieces */
            memmove(heard, heard + used - 256, 256);
            used = 256;
        }
        const ssize_t got = read(child->out_fd, heard + used, sizeof heard - 1 - used);
        if (got == 0 || (got < 0 && errno != EINTR)) {
            return false;
        }
        used += got > 0 ? (size_t)got : 0;
        heard[used] = '\0';
    }
    return true;
}

bool ss_child_is_running(ss_child *child)
{
    int status = 0;
    if (!child->is_running) {
        return false;
    }
    const pid_t ended = waitpid(child->pid, &status, WNOHANG);
    if (ended == 0 || (ended < 0 && errno == EINTR)) {
        return true;
    }
    child->is_running = false;
    child->status = ended < 0             ? -1
                    : WIFEXITED(status)   ? WEXITSTATUS(status)
                    : WIFSIGNALED(status) ? 128 + WTERMSIG(status)
                                          : -1;
    if (child->out_fd >= 0) {
        close(child->out_fd);
        child->out_fd = -1;
    }
    return false;
}

/* Waits until it has ended or `deadline_ns`; `is_patient`: also when the bench is stopped. */
static bool wait_for_end(ss_child *child, int64_t deadline_ns, bool is_patient)
{
    while (ss_child_is_running(child)) {
        const int64_t now_ns = ss_clock_now_ns();
        if (now_ns >= deadline_ns || (!is_patient && ss_process_is_stopped())) {
            return false;
        }
        ss_clock_sleep_until(now_ns + look_ns);
    }
    return true;
}

int ss_child_stop(ss_child *child, double grace_s)
{
    if (ss_child_is_running(child)) {
        kill(child->pid, SIGTERM);
        if (!wait_for_end(child, ss_clock_now_ns() + (int64_t)(1e9 * grace_s), true)) {
            kill(child->pid, SIGKILL);
            wait_for_end(child, INT64_MAX, true);
        }
    }
    return child->status;
}

int ss_child_run(const ss_child_plan *plan, double timeout_s)
{
    ss_child child;
    if (ss_child_start(&child, plan, NULL) != SOFTSIM_OK) {
        return -1;
    }
    wait_for_end(&child, ss_clock_now_ns() + (int64_t)(1e9 * timeout_s), false);
    return ss_child_stop(&child, 1.0);
}

bool ss_child_own_folder(char *out, int size)
{
    const ssize_t length = readlink("/proc/self/exe", out, (size_t)size - 1);
    if (length <= 0 || length >= size - 1) {
        return false;
    }
    out[length] = '\0';
    char *slash = strrchr(out, '/');
    if (slash == NULL) {
        return false;
    }
    *slash = '\0';
    return true;
}

void ss_child_look_above(const char *const place[], bool (*take)(void *context, const char *folder),
                         void *context)
{
    char own[PATH_MAX], folder[PATH_MAX + 64];
    if (take(context, place[0]) || !ss_child_own_folder(own, sizeof own)) {
        return;
    }
    for (char *slash = own + strlen(own); slash != NULL; slash = strrchr(own, '/')) {
        *slash = '\0';
        for (int32_t i = 0; place[i] != NULL; ++i) {
            snprintf(folder, sizeof folder, "%s/%s", own, place[i]);
            if (take(context, folder)) {
                return;
            }
        }
    }
}
