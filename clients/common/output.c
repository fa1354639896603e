/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio_ext.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "rt/clock.h"
#include "rt/each.h"
#include "rt/files.h"
#include "rt/plain.h"

enum {
    RECORDING_BUFFER = 1 << 20, /* bytes: more than a second of rows at 1 kHz */
    MAX_ROWS = 8192,            /* that wait in it */
    MAX_KEPT = 1000             /* recordings of killed programs; then the name is refused */
};
static const int64_t flush_ns = 1000000000;

static void forget(ss_output *output)
{
    SS_EACH(free, output->path, output->temporary, output->kept, output->buffer, output->row_end);
    *output = (ss_output){0};
}

static void remove_temporary(const ss_output *output)
{
    if (output->temporary != NULL) {
        unlink(output->temporary);
    }
}

/* On the same place in the file, so that what the program prints follows. */
static int copy_descriptor(int descriptor)
{
    if ((fcntl(descriptor, F_GETFL) & O_ACCMODE) == O_RDONLY) {
        errno = EBADF; /* also a stdout that was closed: rt/program.h */
        return -1;
    }
    return fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
}

static softsim_status fail_open(ss_output *output, softsim_status status, const char *path,
                                const char *why, softsim_error *error)
{
    softsim_error_add(error, status, "%s: %s", path, why);
    forget(output);
    return status;
}

/* Names the file that is written to. */
static softsim_status prepare(ss_output *output, const char *path, bool is_recording,
                              int *out_descriptor, softsim_error *error)
{
    *output = (ss_output){.path = strdup(path), .is_recording = is_recording};
    *out_descriptor = ss_files_descriptor(path);
    const char *why = path[0] == '\0' ? "the name is empty" : ss_files_why_no_output(path);
    if (why != NULL) {
        return fail_open(output, SOFTSIM_ERROR_FILE, path, why, error);
    }
    const int length = ss_files_is_in_place(path) ? 0
                       : is_recording
                           ? asprintf(&output->temporary, "%s" SS_FILES_PART, path)
                           : asprintf(&output->temporary, "%s.%ld.tmp", path, (long)getpid());
    if (output->path == NULL || length < 0) {
        output->temporary = length < 0 ? NULL : output->temporary;
        return fail_open(output, SOFTSIM_ERROR_MEMORY, path, "out of memory", error);
    }
    return SOFTSIM_OK;
}

static int open_place(const char *path, int descriptor)
{
    return descriptor >= 0 ? copy_descriptor(descriptor)
                           : open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
}

softsim_status ss_output_open(ss_output *output, const char *path, softsim_error *error)
{
    int descriptor = -1;
    const softsim_status status = prepare(output, path, false, &descriptor, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    output->descriptor =
        open_place(output->temporary != NULL ? output->temporary : path, descriptor);
    output->file =
        output->descriptor >= 0 ? ss_files_write_stream(output->descriptor, &output->reason) : NULL;
    if (output->file == NULL) {
        const int reason = errno;
        if (output->descriptor >= 0) {
            remove_temporary(output);
            close(output->descriptor);
        }
        return fail_open(output, SOFTSIM_ERROR_FILE, path, ss_files_reason(reason), error);
    }
    return SOFTSIM_OK;
}

/* Does the name still stand for the open file? Its holder may have renamed it meanwhile. */
static bool is_named(const char *path, const struct stat *open_file)
{
    struct stat found;
    return lstat(path, &found) == 0 && found.st_dev == open_file->st_dev &&
           found.st_ino == open_file->st_ino;
}

/* Opens and holds what stands at `path`, which nobody writes to from then on; -1: *out_why says why
 * not. */
static int hold(const char *path, struct stat *out_found, const char **out_why)
{
    const int part = open(path, O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
    *out_why = NULL;
    if (part < 0) {
        *out_why = ss_files_reason(errno);
    } else if (flock(part, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        *out_why = "another program is recording to it; give another name";
    } else if (fstat(part, out_found) != 0) {
        *out_why = ss_files_reason(errno);
    } else if (!S_ISREG(out_found->st_mode)) {
        *out_why = "not a file; remove it, or give another name";
    } else if (!is_named(path, out_found)) {
        *out_why = "another program has just ended recording to it; start again";
    }
    if (*out_why != NULL && part >= 0) {
        close(part);
    }
    return *out_why == NULL ? part : -1;
}

/* As rename, but never over another file; false with errno set. */
static bool rename_to_free(const char *from, const char *to)
{
    if (renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE) == 0) {
        return true;
    }
    /* Some file systems do not know that flag. */
    return errno == EINVAL && link(from, to) == 0 && unlink(from) == 0;
}

/* Gives the NAME.part that is held the first free of the names NAME.1.part, NAME.2.part, ...; says
 * why not, else NULL. */
static const char *put_aside(ss_output *output)
{
    for (int number = 1; number <= MAX_KEPT; ++number) {
        if (asprintf(&output->kept, "%s.%d" SS_FILES_PART, output->path, number) < 0) {
            output->kept = NULL;
            return "out of memory";
        }
        if (rename_to_free(output->temporary, output->kept)) {
            return NULL;
        }
        const int reason = errno;
        free(output->kept);
        output->kept = NULL;
        if (reason != EEXIST) {
            return ss_files_reason(reason);
        }
    }
    return "left by a program that was killed, as a thousand others; move them away";
}

/* NAME.part, empty and held by this program; -1: *out_why says why not. */
static int open_part(ss_output *output, const char **out_why)
{
    struct stat found;
    const int left = hold(output->temporary, &found, out_why);
    if (left < 0 || found.st_size == 0) {
        return left;
    }
    *out_why = put_aside(output);
    close(left);
    const int part = *out_why == NULL ? hold(output->temporary, &found, out_why) : -1;
    if (part >= 0 && found.st_size > 0) {
        *out_why = "another program has just left a recording there; start again";
        close(part);
    }
    return *out_why == NULL ? part : -1;
}

/* The same where neither name is there yet; -1 without a reason: one is. Who records to NAME holds
 * NAME.part from before it looks for NAME until it has renamed, so that no two take one name. */
static int open_new_part(const ss_output *output, const char **out_why)
{
    struct stat found;
    const int made = open(output->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    *out_why = made < 0 && errno != EEXIST ? ss_files_reason(errno) : NULL;
    if (made < 0) {
        return -1;
    }
    if (flock(made, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        close(made); /* to who asked for this very name */
        return -1;
    }
    if (fstat(made, &found) != 0 || !is_named(output->temporary, &found)) {
        close(made); /* who held it first has recorded to it, and renamed it */
        return -1;
    }
    if (lstat(output->path, &found) == 0) {
        unlink(output->temporary);
        close(made);
        return -1;
    }
    return made;
}

static softsim_status record(ss_output *output, const char *path, bool is_new, softsim_error *error)
{
    int descriptor = -1;
    const char *why = NULL;
    const softsim_status status = prepare(output, path, true, &descriptor, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    output->buffer = malloc(RECORDING_BUFFER);
    output->row_end = malloc(MAX_ROWS * sizeof *output->row_end);
    if (output->buffer == NULL || output->row_end == NULL) {
        return fail_open(output, SOFTSIM_ERROR_MEMORY, path, "out of memory", error);
    }
    output->is_new = is_new && output->temporary != NULL;
    output->descriptor = output->is_new              ? open_new_part(output, &why)
                         : output->temporary != NULL ? open_part(output, &why)
                                                     : open_place(path, descriptor);
    if (output->is_new && output->descriptor < 0 && why == NULL) {
        forget(output);
        return SOFTSIM_OK;
    }
    output->file = output->descriptor >= 0 ? fdopen(output->descriptor, "wb") : NULL;
    if (output->file == NULL) {
        const int number = errno;
        if (output->descriptor >= 0) {
            close(output->descriptor);
        }
        const bool is_parts = why != NULL && access(output->temporary, F_OK) == 0;
        char *name = strdup(is_parts ? output->temporary : path);
        fail_open(output, SOFTSIM_ERROR_FILE, name != NULL ? name : path,
                  why != NULL ? why : ss_files_reason(number), error);
        free(name);
        return SOFTSIM_ERROR_FILE;
    }
    setvbuf(output->file, output->buffer, _IOFBF, RECORDING_BUFFER);
    output->flushed_ns = ss_clock_now_ns();
    return SOFTSIM_OK;
}

softsim_status ss_output_record(ss_output *output, const char *path, softsim_error *error)
{
    return record(output, path, false, error);
}

softsim_status ss_output_record_new(ss_output *output, const char *path, softsim_error *error)
{
    return record(output, path, true, error);
}

void ss_output_tell_kept(const char *kept, const char *part, const char *program)
{
    if (kept != NULL) {
        ss_plain_print(stderr, "%s: %s was left by a program that was killed; it is %s now\n",
                       program, part, kept);
    }
}

void ss_output_tell(const ss_output *output, const char *program)
{
    if (output->file != NULL && output->temporary != NULL) {
        ss_plain_print(stderr, "%s: recording to %s; at the end it becomes %s\n", program,
                       output->temporary, output->path);
    }
}

bool ss_output_pace(ss_output *output)
{
    if (output->row_end == NULL || output->reason != 0) {
        return output->reason == 0;
    }
    const int64_t now_ns = ss_clock_now_ns();
    const size_t pending = __fpending(output->file);
    output->row_end[output->row_count++] = (int32_t)pending;
    if (now_ns - output->flushed_ns < flush_ns && pending < RECORDING_BUFFER / 2 &&
        output->row_count < MAX_ROWS) {
        return true;
    }
    output->flushed_ns = now_ns;
    errno = 0;
    if (ferror(output->file) == 0 && fflush(output->file) == 0) {
        output->whole_bytes = (int64_t)ftello(output->file); /* -1 of a pipe, which is not cut */
        output->row_count = 0;
        return true;
    }
    output->reason = errno != 0 ? errno : EIO;
    return false;
}

/* Writes out and syncs; false with `reason` set. */
static bool write_out(ss_output *output)
{
    errno = 0;
    bool is_good = output->reason == 0 && ferror(output->file) == 0 && fflush(output->file) == 0;
    if (is_good && output->is_reserved) {
        is_good = ftruncate(output->descriptor, lseek(output->descriptor, 0, SEEK_CUR)) == 0;
    }
    if (is_good && fsync(output->descriptor) != 0) {
        is_good = errno == EINVAL || errno == EROFS; /* what cannot be synced: pipes, /dev/null */
    }
    if (!is_good && output->reason == 0) {
        output->reason = errno != 0 ? errno : EIO;
    }
    return is_good;
}

/* Closes a recording that could not be written, cut back to its last whole row. */
static void cut_back(ss_output *output)
{
    struct stat found;
    __fpurge(output->file);
    if (output->temporary != NULL && fstat(output->descriptor, &found) == 0) {
        const int64_t room = (int64_t)found.st_size - output->whole_bytes;
        int32_t k = output->row_count;
        while (k > 0 && output->row_end[k - 1] > room) {
            --k;
        }
        const int64_t whole = output->whole_bytes + (k > 0 ? output->row_end[k - 1] : 0);
        const int result = ftruncate(output->descriptor, (off_t)whole);
        (void)result; /* what is behind the last row is then half a row */
    }
    fclose(output->file);
}

/* Gives what was written its name; false with errno set. */
static bool give_name(const ss_output *output)
{
    struct stat found;
    if (!output->is_new) {
        return rename(output->temporary, output->path) == 0;
    }
    if (rename_to_free(output->temporary, output->path)) {
        return true;
    }
    /* Some file systems know no links either, and do not look whether the name is taken. */
    if (errno == EEXIST || lstat(output->path, &found) == 0) {
        errno = EEXIST;
        return false;
    }
    return rename(output->temporary, output->path) == 0;
}

softsim_status ss_output_commit(ss_output *output, softsim_error *error)
{
    if (output->file == NULL) {
        return SOFTSIM_OK;
    }
    const bool is_whole = write_out(output);
    bool is_good = is_whole;
    if (!is_good && output->is_recording) {
        cut_back(output);
    } else {
        /* While it is held: after the close the name may stand for another program's recording. */
        if (is_good && output->temporary != NULL) {
            is_good = give_name(output);
            output->reason = is_good ? 0 : errno;
        }
        is_good = fclose(output->file) == 0 && is_good;
    }
    if (!is_good) {
        const bool is_kept = output->is_recording && output->temporary != NULL;
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: cannot write: %s%s%s", output->path,
                          ss_files_reason(output->reason != 0 ? output->reason : errno),
                          !is_kept   ? ""
                          : is_whole ? "; it is in "
                                     : "; what was recorded before is in ",
                          is_kept ? output->temporary : "");
        if (!is_kept) {
            remove_temporary(output);
        }
    }
    forget(output);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_FILE;
}

softsim_status ss_output_reserve(ss_output *output, int64_t bytes, softsim_error *error)
{
    if (output->temporary == NULL) {
        return SOFTSIM_OK;
    }
    const int reason = posix_fallocate(output->descriptor, 0, (off_t)bytes);
    output->is_reserved = true;
    output->reason = reason != EINTR ? reason : 0; /* by a signal: without the room */
    return output->reason == 0 ? SOFTSIM_OK : ss_output_commit(output, error);
}

void ss_output_keep(ss_output *output, softsim_error *error)
{
    if (output->file == NULL) {
        return;
    }
    if (!write_out(output) || output->temporary == NULL) {
        (void)ss_output_commit(output, error);
        return;
    }
    fclose(output->file);
    softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: not complete; what was recorded is in %s",
                      output->path, output->temporary);
    forget(output);
}

void ss_output_abandon(ss_output *output)
{
    if (output->file != NULL) {
        remove_temporary(output); /* while it is held */
        fclose(output->file);
        forget(output);
    }
}
