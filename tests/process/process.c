/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "process.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <net/if.h>
#include <net/route.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

double process_now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool raise_loopback(void)
{
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    struct ifreq request = {.ifr_name = "lo"};
    bool ok = fd >= 0 && ioctl(fd, SIOCGIFFLAGS, &request) == 0;
    request.ifr_flags |= IFF_UP;
    ok = ok && ioctl(fd, SIOCSIFFLAGS, &request) == 0;
    /* 224.0.0.0/4 dev lo */
    char device[] = "lo";
    struct rtentry route = {.rt_flags = RTF_UP, .rt_dev = device};
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr.s_addr = inet_addr("224.0.0.0")};
    memcpy(&route.rt_dst, &address, sizeof address);
    address.sin_addr.s_addr = inet_addr("240.0.0.0");
    memcpy(&route.rt_genmask, &address, sizeof address);
    ok = ok && ioctl(fd, SIOCADDRT, &route) == 0;
    if (fd >= 0) {
        close(fd);
    }
    return ok;
}

bool process_isolate(void)
{
    unsetenv("LCM_DEFAULT_URL");
    if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
        fprintf(stderr, "skipped: no private network namespace allowed here\n");
        return false;
    }
    return raise_loopback();
}

void process_start(process *p, const char *const *argv, const char *const *environment)
{
    memset(p, 0, sizeof *p);
    int out[2], err[2];
    if (pipe2(out, O_CLOEXEC) != 0 || pipe2(err, O_CLOEXEC) != 0) {
        abort();
    }
    p->pid = fork();
    if (p->pid < 0) {
        abort();
    }
    if (p->pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL); /* a test that is killed leaves nothing running */
        dup2(out[1], STDOUT_FILENO);
        dup2(err[1], STDERR_FILENO);
        const int null = open("/dev/null", O_RDONLY | O_CLOEXEC);
        dup2(null, STDIN_FILENO);
        for (int i = 0; environment && environment[i]; ++i) {
            putenv((char *)environment[i]);
        }
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", BIN_DIR, argv[0]);
        execv(path, (char *const *)argv);
        fprintf(stderr, "cannot start %s: %s\n", path, strerror(errno));
        _exit(127);
    }
    close(out[1]);
    close(err[1]);
    p->out_fd = out[0];
    p->err_fd = err[0];
    p->is_running = true;
}

/* Reads what is there; closes at the end of file. Output beyond the buffer is read and dropped. */
static void drain(int *fd, char *buffer, int *size, int capacity)
{
    char chunk[4096];
    const ssize_t got = read(*fd, chunk, sizeof chunk);
    if (got > 0) {
        const int room = capacity - 1 - *size;
        const int keep = got < room ? (int)got : room;
        memcpy(buffer + *size, chunk, (size_t)keep);
        *size += keep;
        buffer[*size] = '\0';
    } else if (got == 0 || errno != EINTR) {
        close(*fd);
        *fd = -1;
    }
}

static bool pump(process *p, double deadline)
{
    struct pollfd fds[2] = {{.fd = p->out_fd, .events = POLLIN},
                            {.fd = p->err_fd, .events = POLLIN}};
    if (p->out_fd < 0 && p->err_fd < 0) {
        return false;
    }
    const double left = deadline - process_now_s();
    if (left <= 0.0 || poll(fds, 2, (int)(left * 1e3) + 1) < 0) {
        return false;
    }
    if (p->out_fd >= 0 && fds[0].revents) {
        drain(&p->out_fd, p->out, &p->out_size, sizeof p->out);
    }
    if (p->err_fd >= 0 && fds[1].revents) {
        drain(&p->err_fd, p->err, &p->err_size, sizeof p->err);
    }
    return true;
}

bool process_wait_for(process *p, const char *text)
{
    const double deadline = process_now_s() + HANG_S;
    while (!strstr(p->out, text) && !strstr(p->err, text)) {
        if (!pump(p, deadline)) {
            return false;
        }
    }
    return true;
}

int process_finish(process *p)
{
    if (!p->is_running) {
        return p->status;
    }
    const double deadline = process_now_s() + HANG_S;
    while (pump(p, deadline)) {
    }
    const bool is_late = p->out_fd >= 0 || p->err_fd >= 0;
    if (is_late) {
        kill(p->pid, SIGKILL);
    }
    int status = 0;
    waitpid(p->pid, &status, 0);
    p->status = is_late               ? -1
                : WIFEXITED(status)   ? WEXITSTATUS(status)
                : WIFSIGNALED(status) ? 128 + WTERMSIG(status)
                                      : -1;
    for (int i = 0; i < 2; ++i) {
        int *fd = i == 0 ? &p->out_fd : &p->err_fd;
        if (*fd >= 0) {
            close(*fd);
            *fd = -1;
        }
    }
    p->is_running = false;
    return p->status;
}

bool process_has_ended(const process *p)
{
    siginfo_t info = {.si_pid = 0};
    return !p->is_running ||
           (waitid(P_PID, (id_t)p->pid, &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
            info.si_pid == p->pid);
}

void process_signal(process *p, int signal_number)
{
    if (p->is_running) {
        kill(p->pid, signal_number);
    }
}

void process_kill(process *p)
{
    process_signal(p, SIGKILL);
    process_finish(p);
}

int process_run(process *p, const char *const *argv)
{
    process_start(p, argv, NULL);
    return process_finish(p);
}
