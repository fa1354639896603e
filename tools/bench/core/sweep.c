/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/core/sweep.h"
/*
 * A part is a head line and records, each whole or not there:
 *
 *   softsim-sweep 1 NAME FINGERPRINT COUNT
 *   here JOB                          the rank is at work, for this start of mpirun
 *   run INDEX g|l LENGTH CHECK        g: its text; l: lost, and the text is the reason
 *   LENGTH bytes of text, a line end
 *
 * FINGERPRINT is FNV-1a 64 over the program itself and all labels, CHECK over the text. A record is
 * one write at the end of the file, so that a killed process leaves at most one torn record, the
 * last; it is cut off by its own rank, and by others not yet read. Since a rank does the runs i
 * with i mod n = r whatever is done already, no two ranks ever do the same run, and a sweep may be
 * taken up with another number of them. Rank 0 waits for every rank's `here`, even with nothing
 * left to do: otherwise a rank that starts late finds the parts removed and does its runs once
 * more.
 */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "process.h"
#include "rt/clock.h"
#include "rt/hash.h"
#include "rt/memory.h"

enum {
    PATH_SIZE = 4096,
    HEAD_SIZE = 256,
    MAX_PARTS = 4096,
    MAX_RANKS = MAX_PARTS,
    WAIT_MS = 50,
    JOB_SIZE = 64
};
static const int64_t second_ns = 1000000000;
static const int64_t show_ns = 200000000;
static const int64_t plain_ns = 10000000000;
static const int64_t look_ns = 200000000; /* between looks at the other ranks' parts */
/* s: a folder over a network may be seen this late. */
static const double silence_s = 120.0;

/* A part of any rank, read up to `offset`. */
typedef struct part {
    char name[NAME_MAX + 1];
    off_t offset;
    bool is_here; /* it belongs to a rank of this start of mpirun */
} part;

/* A run under way. */
typedef struct slot {
    pid_t pid; /* 0: free */
    int fd;
    int32_t index;
    int64_t start_ns;
    char *text;
    size_t used;
} slot;

typedef struct sweeper {
    const ss_sweep *sweep;
    ss_sweep_result *result;
    int32_t rank, ranks;
    char job[JOB_SIZE]; /* this start of mpirun */
    char head[HEAD_SIZE];
    part *parts;
    int32_t part_count;
    int part_fd; /* of our own; -1: not open */
    slot *slots;
    int32_t next; /* the least run of ours that was not looked at */
    int32_t done; /* in this session */
    int64_t begin_ns, shown_ns, synced_ns;
    bool is_shown, is_terminal; /* else a line every ten seconds */
} sweeper;

/* ---- the list ---- */

/* What results depend on: the program, and what every run is. */
static uint64_t fingerprint(const ss_sweep *sweep)
{
    static char block[1 << 16];
    char label[SS_SWEEP_NAME_SIZE];
    uint64_t hash = ss_hash_bytes(SS_HASH_START, SOFTSIM_VERSION, sizeof SOFTSIM_VERSION);
    FILE *program = fopen("/proc/self/exe", "re");
    for (size_t got = 1; program != NULL && got > 0;) {
        got = fread(block, 1, sizeof block, program);
        hash = ss_hash_bytes(hash, block, got);
    }
    if (program != NULL) {
        fclose(program);
    }
    for (int32_t i = 0; i < sweep->count; ++i) {
        memset(label, 0, sizeof label);
        sweep->label(sweep->context, i, label);
        hash = ss_hash_bytes(hash, label, strlen(label) + 1);
    }
    return hash;
}

/* A number of the environment within min..max, else `fallback`. */
static int32_t environment_number(const char *name, int32_t min, int32_t max, int32_t fallback)
{
    const char *text = getenv(name);
    char *end = NULL;
    const long value = text != NULL ? strtol(text, &end, 10) : 0;
    return text != NULL && end != text && *end == '\0' && value >= min && value <= max
               ? (int32_t)value
               : fallback;
}

/* ---- parts ---- */

static bool is_part_name(const ss_sweep *sweep, const char *name)
{
    const size_t length = strlen(sweep->name);
    int end = 0;
    int rank = 0;
    return strncmp(name, sweep->name, length) == 0 &&
           sscanf(name + length, ".%d.part%n", &rank, &end) == 1 && end > 0 &&
           name[length + (size_t)end] == '\0';
}

static part *find_part(sweeper *s, const char *name)
{
    for (int32_t i = 0; i < s->part_count; ++i) {
        if (strcmp(s->parts[i].name, name) == 0) {
            return &s->parts[i];
        }
    }
    if (s->part_count == MAX_PARTS) {
        return NULL;
    }
    part *added = &s->parts[s->part_count++];
    *added = (part){.offset = 0};
    snprintf(added->name, sizeof added->name, "%s", name);
    return added;
}

/* Is this the head line of our sweep? -1: not yet written in full; 0: of another. */
static int read_head(const sweeper *s, FILE *file)
{
    char line[HEAD_SIZE] = "";
    const size_t length = strlen(s->head);
    const size_t got = fread(line, 1, length, file);
    if (memcmp(line, s->head, got) != 0) {
        return 0;
    }
    return got == length ? 1 : -1;
}

/* Takes over a result; the first one of a run counts. */
static bool store_result(sweeper *s, int32_t index, bool is_lost, const char *text)
{
    ss_sweep_run *run = &s->result->run[index];
    if (run->text != NULL) {
        return true;
    }
    run->text = strdup(text);
    run->is_lost = is_lost;
    s->result->lost += is_lost;
    return run->text != NULL;
}

/* The record of a run whose first line is `line`; false when it is not whole. `text` holds
 * SS_SWEEP_MAX_TEXT bytes. */
static bool read_run(const sweeper *s, const char *line, FILE *file, int32_t *out_index,
                     bool *out_is_lost, char *text)
{
    char kind = 0;
    size_t length = 0;
    uint64_t check = 0;
    if (sscanf(line, "run %" SCNd32 " %c %zu %" SCNx64, out_index, &kind, &length, &check) != 4 ||
        *out_index < 0 || *out_index >= s->sweep->count || (kind != 'g' && kind != 'l') ||
        length >= SS_SWEEP_MAX_TEXT || fread(text, 1, length, file) != length ||
        fgetc(file) != '\n' || ss_hash_bytes(SS_HASH_START, text, length) != check) {
        return false;
    }
    text[length] = '\0';
    *out_is_lost = kind == 'l';
    return strlen(text) == length;
}

/* Takes over the next record; false where no whole one is left. */
static bool read_record(sweeper *s, part *from, FILE *file, char *text, softsim_status *out_status)
{
    char line[128];
    char job[JOB_SIZE] = "";
    int32_t index = 0;
    bool is_lost = false;
    if (fgets(line, sizeof line, file) == NULL || strchr(line, '\n') == NULL) {
        return false;
    }
    if (sscanf(line, "here %63s", job) == 1) {
        from->is_here = strcmp(job, s->job) == 0;
        return true;
    }
    if (!read_run(s, line, file, &index, &is_lost, text)) {
        return false;
    }
    *out_status = store_result(s, index, is_lost, text) ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
    return *out_status == SOFTSIM_OK;
}

/* Reads what is new in one part. */
static softsim_status read_part(sweeper *s, part *from, char *text, softsim_error *error)
{
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s", s->sweep->folder, from->name);
    FILE *file = fopen(path, "re");
    softsim_status status = SOFTSIM_OK;
    if (file == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: %s", path, strerror(errno));
        return SOFTSIM_ERROR_FILE;
    }
    if (from->offset == 0) {
        const int head = read_head(s, file);
        if (head == 0) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "%s: begun with other options or files, or by another build of "
                              "this program: remove it, or give another --out",
                              path);
            status = SOFTSIM_ERROR_ARGUMENT;
        }
        from->offset = head == 1 ? (off_t)strlen(s->head) : 0;
    } else if (fseeko(file, from->offset, SEEK_SET) != 0) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: %s", path, strerror(errno));
        status = SOFTSIM_ERROR_FILE;
    }
    while (status == SOFTSIM_OK && from->offset > 0 && read_record(s, from, file, text, &status)) {
        from->offset = ftello(file);
    }
    if (status == SOFTSIM_ERROR_MEMORY) {
        status = ss_memory_fault(error);
    }
    fclose(file);
    return status;
}

static softsim_status read_parts(sweeper *s, softsim_error *error)
{
    DIR *folder = opendir(s->sweep->folder);
    char *text = malloc(SS_SWEEP_MAX_TEXT);
    softsim_status status = SOFTSIM_OK;
    if (folder == NULL || text == NULL) {
        status = folder == NULL ? SOFTSIM_ERROR_FILE : SOFTSIM_ERROR_MEMORY;
        softsim_error_add(error, status, "%s: %s", s->sweep->folder,
                          folder == NULL ? strerror(errno) : "out of memory");
        goto done;
    }
    for (const struct dirent *at = readdir(folder); at != NULL; at = readdir(folder)) {
        part *from = is_part_name(s->sweep, at->d_name) ? find_part(s, at->d_name) : NULL;
        if (from != NULL) {
            const softsim_status one = read_part(s, from, text, error);
            status = status == SOFTSIM_OK ? one : status;
        }
    }
done:
    free(text);
    if (folder != NULL) {
        closedir(folder);
    }
    return status;
}

static bool write_all(int fd, const char *data, size_t size)
{
    while (size > 0) {
        const ssize_t put = write(fd, data, size);
        if (put < 0 && errno != EINTR) {
            return false;
        }
        data += put > 0 ? put : 0;
        size -= put > 0 ? (size_t)put : 0;
    }
    return true;
}

static softsim_status cannot_write(const sweeper *s, softsim_error *error)
{
    softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s/%s.%d.part: cannot write: %s",
                      s->sweep->folder, s->sweep->name, s->rank, strerror(errno));
    return SOFTSIM_ERROR_FILE;
}

/* Opens our own part behind its last whole record; read_parts has been called. */
static softsim_status open_part(sweeper *s, softsim_error *error)
{
    char name[NAME_MAX + 1], path[PATH_SIZE];
    snprintf(name, sizeof name, "%s.%d.part", s->sweep->name, s->rank);
    snprintf(path, sizeof path, "%s/%s", s->sweep->folder, name);
    part *own = find_part(s, name);
    s->part_fd = open(path, O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (s->part_fd < 0 || own == NULL) {
        return cannot_write(s, error);
    }
    if (flock(s->part_fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE,
                          "%s: another process is at this sweep: wait for it, or give another "
                          "--out",
                          path);
        return SOFTSIM_ERROR_FILE;
    }
    /* What another process wrote between our look and the lock is not to be cut off. */
    const softsim_status status = read_parts(s, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    char here[JOB_SIZE + 8];
    snprintf(here, sizeof here, "here %s\n", s->job);
    if (ftruncate(s->part_fd, own->offset) != 0 ||
        (own->offset == 0 && !write_all(s->part_fd, s->head, strlen(s->head))) ||
        !write_all(s->part_fd, here, strlen(here))) {
        return cannot_write(s, error);
    }
    own->is_here = true;
    return SOFTSIM_OK;
}

static void sync_part(sweeper *s, int64_t now_ns)
{
    if (now_ns - s->synced_ns >= second_ns && fdatasync(s->part_fd) == 0) {
        s->synced_ns = now_ns;
    }
}

static softsim_status put_record(sweeper *s, int32_t index, bool is_lost, const char *text,
                                 softsim_error *error)
{
    char line[128];
    const size_t length = strlen(text);
    const int head =
        snprintf(line, sizeof line, "run %" PRId32 " %c %zu %016" PRIx64 "\n", index,
                 is_lost ? 'l' : 'g', length, ss_hash_bytes(SS_HASH_START, text, length));
    char *record = malloc((size_t)head + length + 1);
    if (record == NULL || !store_result(s, index, is_lost, text)) {
        free(record);
        return ss_memory_fault(error);
    }
    memcpy(record, line, (size_t)head);
    memcpy(record + head, text, length);
    record[(size_t)head + length] = '\n';
    const bool is_written = write_all(s->part_fd, record, (size_t)head + length + 1);
    free(record);
    ++s->done;
    return is_written ? SOFTSIM_OK : cannot_write(s, error);
}

/* ---- runs ---- */

/* In the run's own process: a letter, then its text or why there is none. */
_Noreturn static void do_run(const sweeper *s, int32_t index, int fd, pid_t parent)
{
    const ss_sweep *sweep = s->sweep;
    softsim_error error = {.status = SOFTSIM_OK};
    char *text = NULL;
    size_t size = 0;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    close(s->part_fd); /* a run that outlives us for a moment must not keep our lock */
    /* A terminal's interrupt goes to all of us: the sweep stops, and this run is not lost. */
    signal(SIGINT, SIG_IGN);
    signal(SIGTERM, SIG_IGN);
    signal(SIGHUP, SIG_IGN);
    FILE *out = getppid() == parent ? open_memstream(&text, &size) : NULL;
    if (out == NULL) {
        _exit(EXIT_FAILURE);
    }
    const softsim_status status = sweep->run(sweep->context, index, out, &error);
    if (fclose(out) != 0) {
        _exit(EXIT_FAILURE);
    }
    if (status != SOFTSIM_OK) {
        const char *reason = error.text[0] != '\0' ? error.text : softsim_status_text(status);
        const bool is_put = write_all(fd, "l", 1) && write_all(fd, reason, strcspn(reason, "\n"));
        _exit(is_put ? EXIT_SUCCESS : EXIT_FAILURE);
    }
    _exit(write_all(fd, "g", 1) && write_all(fd, text, size) ? EXIT_SUCCESS : EXIT_FAILURE);
}

static softsim_status start_run(sweeper *s, slot *to, int32_t index, softsim_error *error)
{
    int pipe_fd[2];
    if (pipe2(pipe_fd, O_CLOEXEC) != 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "cannot start a run: %s", strerror(errno));
        return SOFTSIM_ERROR_SYSTEM;
    }
    const pid_t parent = getpid();
    to->pid = fork();
    if (to->pid == 0) {
        close(pipe_fd[0]);
        do_run(s, index, pipe_fd[1], parent);
    }
    close(pipe_fd[1]);
    if (to->pid < 0) {
        to->pid = 0;
        close(pipe_fd[0]);
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "cannot start a run: %s", strerror(errno));
        return SOFTSIM_ERROR_SYSTEM;
    }
    to->fd = pipe_fd[0];
    to->index = index;
    to->start_ns = ss_clock_now_ns();
    to->used = 0;
    return SOFTSIM_OK;
}

/* The run's process is gone or goes now; returns how it ended, as waitpid tells. */
static int reap(slot *of, bool is_killed)
{
    int status = 0;
    if (is_killed) {
        kill(of->pid, SIGKILL);
    }
    while (waitpid(of->pid, &status, 0) < 0 && errno == EINTR) {
    }
    close(of->fd);
    of->pid = 0;
    return status;
}

static softsim_status record_lost_run(sweeper *s, slot *of, const char *reason,
                                      softsim_error *error)
{
    return put_record(s, of->index, true, reason, error);
}

/* Its pipe is closed: what it left, or how it was lost. */
static softsim_status end_run(sweeper *s, slot *of, softsim_error *error)
{
    char reason[96];
    const int status = reap(of, false);
    of->text[of->used] = '\0';
    if (WIFSIGNALED(status)) {
        snprintf(reason, sizeof reason, "crashed: %s", strsignal(WTERMSIG(status)));
        return record_lost_run(s, of, reason, error);
    }
    const char kind = of->text[0];
    if (!WIFEXITED(status) || WEXITSTATUS(status) != EXIT_SUCCESS || (kind != 'g' && kind != 'l') ||
        strlen(of->text) != of->used) {
        snprintf(reason, sizeof reason, "crashed: ended with status %d and no result",
                 WIFEXITED(status) ? WEXITSTATUS(status) : status);
        return record_lost_run(s, of, reason, error);
    }
    return put_record(s, of->index, kind == 'l', of->text + 1, error);
}

/* Reads what has come; at the end, too much, or too late, the run is over. */
static softsim_status read_run_output(sweeper *s, slot *to, bool is_ready, int64_t now_ns,
                                      softsim_error *error)
{
    if (is_ready) {
        const ssize_t got = read(to->fd, to->text + to->used, SS_SWEEP_MAX_TEXT - to->used);
        if (got == 0 || (got < 0 && errno != EINTR)) {
            return end_run(s, to, error);
        }
        to->used += got > 0 ? (size_t)got : 0;
        if (to->used == SS_SWEEP_MAX_TEXT) {
            reap(to, true);
            return record_lost_run(s, to, "crashed: it left more text than a run may", error);
        }
    }
    if (1e-9 * (double)(now_ns - to->start_ns) > s->sweep->timeout_s) {
        char reason[64];
        reap(to, true);
        snprintf(reason, sizeof reason, "timed out after %g s", s->sweep->timeout_s);
        return record_lost_run(s, to, reason, error);
    }
    return SOFTSIM_OK;
}

/* The next run of ours that is not done; -1: none. */
static int32_t next_own_run(sweeper *s)
{
    while (s->next < s->sweep->count &&
           (s->next % s->ranks != s->rank || s->result->run[s->next].text != NULL)) {
        ++s->next;
    }
    return s->next < s->sweep->count ? s->next++ : -1;
}

static int32_t count_left(const sweeper *s, bool is_all)
{
    int32_t left = 0;
    for (int32_t i = 0; i < s->sweep->count; ++i) {
        left += s->result->run[i].text == NULL && (is_all || i % s->ranks == s->rank);
    }
    return left;
}

static void print_progress(sweeper *s, int64_t now_ns, const char *what)
{
    if (!s->is_shown || now_ns - s->shown_ns < (s->is_terminal ? show_ns : plain_ns)) {
        return;
    }
    const int32_t left = count_left(s, false);
    const double spent_s = 1e-9 * (double)(now_ns - s->begin_ns);
    s->shown_ns = now_ns;
    fprintf(stderr, "%s%d of %d",
            s->is_terminal ? "\r" : "softsim-bench: ", s->sweep->count - count_left(s, true),
            s->sweep->count);
    if (what == NULL && s->done > 0) {
        fprintf(stderr, ", about %.0f s left", spent_s * left / s->done);
    }
    fprintf(stderr, ", %d lost%s%s", s->result->lost, what != NULL ? what : "",
            s->is_terminal ? " " : "\n");
}

static softsim_status stopped(const sweeper *s, softsim_error *error)
{
    softsim_error_add(error, SOFTSIM_ERROR_SYSTEM,
                      "stopped after %d of %d runs: the same command goes on from there",
                      s->sweep->count - count_left(s, true), s->sweep->count);
    return SOFTSIM_ERROR_SYSTEM;
}

/* One round: free slots start runs, the others are listened to. `*out_busy`: slots in use. */
static softsim_status do_round(sweeper *s, int32_t *out_busy, softsim_error *error)
{
    static struct pollfd wait[SS_SWEEP_MAX_JOBS];
    const int32_t jobs = s->sweep->jobs;
    softsim_status status = SOFTSIM_OK;
    *out_busy = 0;
    for (int32_t k = 0; status == SOFTSIM_OK && k < jobs; ++k) {
        const int32_t index = s->slots[k].pid == 0 ? next_own_run(s) : -1;
        if (index >= 0) {
            status = start_run(s, &s->slots[k], index, error);
        }
        wait[k] =
            (struct pollfd){.fd = s->slots[k].pid != 0 ? s->slots[k].fd : -1, .events = POLLIN};
        *out_busy += s->slots[k].pid != 0;
    }
    if (status != SOFTSIM_OK || *out_busy == 0 || poll(wait, (nfds_t)jobs, WAIT_MS) < 0) {
        return status;
    }
    const int64_t now_ns = ss_clock_now_ns();
    for (int32_t k = 0; status == SOFTSIM_OK && k < jobs; ++k) {
        if (s->slots[k].pid != 0) {
            status = read_run_output(s, &s->slots[k], wait[k].revents != 0, now_ns, error);
        }
    }
    sync_part(s, now_ns);
    print_progress(s, now_ns, NULL);
    return status;
}

/* All runs of our own. */
static softsim_status do_share(sweeper *s, softsim_error *error)
{
    softsim_status status = SOFTSIM_OK;
    int32_t busy = 1;
    while (status == SOFTSIM_OK && busy > 0) {
        status = ss_process_is_stopped() ? stopped(s, error) : do_round(s, &busy, error);
    }
    for (int32_t k = 0; k < s->sweep->jobs; ++k) {
        if (s->slots[k].pid != 0) {
            reap(&s->slots[k], true);
        }
    }
    s->synced_ns = 0;
    sync_part(s, ss_clock_now_ns());
    return status;
}

/* Ranks that have not yet begun. */
static int32_t count_missing(const sweeper *s)
{
    int32_t here = 0;
    for (int32_t i = 0; i < s->part_count; ++i) {
        here += s->parts[i].is_here;
    }
    return here < s->ranks ? s->ranks - here : 0;
}

/* Rank 0: until the others have done theirs. */
static softsim_status wait_for_others(sweeper *s, softsim_error *error)
{
    int64_t heard_ns = ss_clock_now_ns();
    int32_t left = count_left(s, true) + count_missing(s);
    while (left > 0) {
        const softsim_status status =
            ss_process_is_stopped() ? stopped(s, error) : read_parts(s, error);
        if (status != SOFTSIM_OK) {
            return status;
        }
        const int32_t now_left = count_left(s, true) + count_missing(s);
        const int64_t now_ns = ss_clock_now_ns();
        heard_ns = now_left < left ? now_ns : heard_ns;
        left = now_left;
        if (1e-9 * (double)(now_ns - heard_ns) > s->sweep->timeout_s + silence_s) {
            softsim_error_add(error, SOFTSIM_ERROR_SYSTEM,
                              "%d runs of other ranks do not come, %d ranks have not begun: do all "
                              "machines see %s? The same command goes on from here",
                              count_left(s, true), count_missing(s), s->sweep->folder);
            return SOFTSIM_ERROR_SYSTEM;
        }
        print_progress(s, now_ns, ", waiting for other ranks");
        if (left > 0) {
            ss_clock_sleep_until(now_ns + look_ns);
        }
    }
    return SOFTSIM_OK;
}

/* ---- the whole ---- */

static bool allocate(sweeper *s)
{
    const size_t jobs = (size_t)s->sweep->jobs;
    s->result->run = calloc((size_t)s->sweep->count + 1, sizeof *s->result->run);
    s->parts = calloc(MAX_PARTS, sizeof *s->parts);
    s->slots = calloc(jobs, sizeof *s->slots);
    bool is_good = s->result->run != NULL && s->parts != NULL && s->slots != NULL;
    for (size_t k = 0; is_good && k < jobs; ++k) {
        s->slots[k].text = malloc(SS_SWEEP_MAX_TEXT + 1);
        is_good = s->slots[k].text != NULL;
    }
    return is_good;
}

static void release(sweeper *s)
{
    for (int32_t k = 0; s->slots != NULL && k < s->sweep->jobs; ++k) {
        free(s->slots[k].text);
    }
    free(s->slots);
    free(s->parts);
    if (s->part_fd >= 0) {
        close(s->part_fd);
    }
}

softsim_status ss_sweep_execute(const ss_sweep *sweep, ss_sweep_result *out_result,
                                softsim_error *error)
{
    *out_result = (ss_sweep_result){.count = sweep->count};
    const int32_t ranks = environment_number("OMPI_COMM_WORLD_SIZE", 1, MAX_RANKS, 1);
    sweeper s = {.sweep = sweep,
                 .result = out_result,
                 .ranks = ranks,
                 .rank = environment_number("OMPI_COMM_WORLD_RANK", 0, ranks - 1, 0),
                 .part_fd = -1,
                 .begin_ns = ss_clock_now_ns()};
    const char *job = getenv("PMIX_NAMESPACE");
    snprintf(s.job, sizeof s.job, "%s", job != NULL && s.ranks > 1 ? job : "-");
    s.is_shown = s.rank == 0;
    s.is_terminal = isatty(STDERR_FILENO) == 1;
    s.shown_ns = s.is_terminal ? 0 : s.begin_ns;
    snprintf(s.head, sizeof s.head, "softsim-sweep 1 %s %016" PRIx64 " %" PRId32 "\n", sweep->name,
             fingerprint(sweep), sweep->count);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (!allocate(&s)) {
        status = ss_memory_fault(error);
    } else {
        status = read_parts(&s, error);
    }
    if (status == SOFTSIM_OK) {
        status = open_part(&s, error);
    }
    if (status == SOFTSIM_OK) {
        out_result->resumed = sweep->count - count_left(&s, true);
        status = do_share(&s, error);
    }
    if (status == SOFTSIM_OK && s.rank == 0) {
        status = wait_for_others(&s, error);
        out_result->is_complete = status == SOFTSIM_OK;
    }
    if (s.is_shown && s.is_terminal) {
        fprintf(stderr, "\r%60s\r", "");
    }
    release(&s);
    return status;
}

void ss_sweep_forget(const ss_sweep *sweep, const ss_sweep_result *result)
{
    DIR *folder = result->is_complete ? opendir(sweep->folder) : NULL;
    if (folder == NULL) {
        return;
    }
    for (const struct dirent *at = readdir(folder); at != NULL; at = readdir(folder)) {
        if (is_part_name(sweep, at->d_name)) {
            unlinkat(dirfd(folder), at->d_name, 0);
        }
    }
    closedir(folder);
}

void ss_sweep_result_fini(ss_sweep_result *result)
{
    for (int32_t i = 0; result->run != NULL && i < result->count; ++i) {
        free(result->run[i].text);
    }
    free(result->run);
    *result = (ss_sweep_result){0};
}

softsim_status ss_sweep_and_report(const ss_sweep *sweep, ss_sweep_report report, void *context,
                                   int32_t *out_lost, softsim_error *error)
{
    ss_sweep_result result;
    softsim_status status = ss_sweep_execute(sweep, &result, error);
    if (status == SOFTSIM_OK && result.is_complete) {
        status = report(context, &result, error);
        if (status == SOFTSIM_OK) {
            ss_sweep_forget(sweep, &result);
        }
    }
    *out_lost = result.lost;
    ss_sweep_result_fini(&result);
    return status;
}
