/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Pictures go into the page as data addresses (RFC 2397), not as inline SVG: several gnuplot
 * pictures in one document would share their ids.
 */
#include "bench/core/report.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bench/core/child.h"
#include "case/scratch.h"
#include "process.h"

enum { MAX_PICTURE = 8 * 1024 * 1024, PATH_SIZE = 4096 };
static const double gnuplot_timeout_s = 60.0;

/* Is there a gnuplot in the PATH? */
static bool has_gnuplot(void)
{
    char path[PATH_SIZE];
    const char *at = getenv("PATH");
    for (; at != NULL && *at != '\0'; at += *at == ':') {
        const int length = (int)strcspn(at, ":");
        snprintf(path, sizeof path, "%.*s/gnuplot", length, at);
        if (access(path, X_OK) == 0) {
            return true;
        }
        at += length;
    }
    return false;
}

/* Once a run: a report of an hour should not end in a surprise. */
static void warn_of_pictures(void)
{
    static bool is_said;
    if (!is_said && !has_gnuplot()) {
        fprintf(stderr, "softsim-bench: gnuplot is not installed, so the report will have no "
                        "pictures: install gnuplot (Debian: gnuplot-nox)\n");
        is_said = true;
    }
}

softsim_status ss_report_begin(const char *folder, char *scratch, softsim_error *error)
{
    ss_process_catch_stop();
    softsim_status status = ss_report_make_folder(folder, error);
    if (status == SOFTSIM_OK && scratch != NULL) {
        status = ss_scratch_make("softsim-bench", scratch, error);
    }
    return status;
}

softsim_status ss_report_make_folder(const char *folder, softsim_error *error)
{
    char path[PATH_SIZE];
    warn_of_pictures();
    const size_t length = strlen(folder);
    if (length == 0 || length >= sizeof path) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "--out: not the name of a folder");
        return SOFTSIM_ERROR_ARGUMENT;
    }
    for (size_t i = 1; i <= length; ++i) {
        if (folder[i] != '/' && folder[i] != '\0') {
            continue;
        }
        snprintf(path, sizeof path, "%.*s", (int)i, folder);
        if (mkdir(path, 0777) != 0 && errno != EEXIST) {
            softsim_error_add(error, SOFTSIM_ERROR_FILE, "--out: cannot make the folder %s: %s",
                              path, strerror(errno));
            return SOFTSIM_ERROR_FILE;
        }
    }
    return SOFTSIM_OK;
}

/* ---- HTML ---- */

static void put_escaped(FILE *file, const char *text)
{
    for (; *text != '\0'; ++text) {
        static const char special[] = "<>&\"";
        static const char *const written[] = {"&lt;", "&gt;", "&amp;", "&quot;"};
        const char *found = strchr(special, *text);
        if (found != NULL) {
            fputs(written[found - special], file);
        } else {
            fputc(*text, file);
        }
    }
}

softsim_status ss_page_open(ss_page *page, const char *folder, const char *name, const char *title,
                            softsim_error *error)
{
    char path[PATH_SIZE];
    *page = (ss_page){.folder = folder};
    snprintf(path, sizeof path, "%s/%s.html", folder, name);
    const softsim_status status = ss_output_open(&page->output, path, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = page->output.file;
    fputs("<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<title>", file);
    put_escaped(file, title);
    fputs("</title>\n<style>body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;"
          "padding:0 1em;color:#222}table{border-collapse:collapse;margin:1em 0}"
          "td,th{border-bottom:1px solid #ddd;padding:.2em .8em;text-align:left}"
          "td.n{text-align:right;font-variant-numeric:tabular-nums}img{max-width:100%}"
          "figcaption{color:#555}figure{margin:1.5em 0}</style></head><body>\n<h1>",
          file);
    put_escaped(file, title);
    fputs("</h1>\n", file);
    return SOFTSIM_OK;
}

void ss_page_heading(ss_page *page, const char *text)
{
    fputs("<h2>", page->output.file);
    put_escaped(page->output.file, text);
    fputs("</h2>\n", page->output.file);
}

void ss_page_text(ss_page *page, const char *format, ...)
{
    char text[2001];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    fputs("<p>", page->output.file);
    put_escaped(page->output.file, text);
    fputs("</p>\n", page->output.file);
}

void ss_page_code(ss_page *page, const char *text)
{
    fputs("<pre>", page->output.file);
    put_escaped(page->output.file, text);
    fputs("</pre>\n", page->output.file);
}

void ss_page_link(ss_page *page, const char *file)
{
    FILE *out = page->output.file;
    fputs("<p>Data: <a href=\"", out);
    put_escaped(out, file);
    fputs("\">", out);
    put_escaped(out, file);
    fputs("</a></p>\n", out);
}

/* "0.501 (+0.2 %)" and "44, all" too, but no sentence that begins with a number. */
static bool is_number(const char *text)
{
    enum { LONGEST = 24 };
    char *end = NULL;
    strtod(text, &end);
    return end != text && strlen(text) <= LONGEST &&
           (*end == '\0' || isspace((unsigned char)*end) || *end == '%' || *end == ',');
}

void ss_page_table_begin(ss_page *page, int32_t count, const char *const *cell)
{
    fputs("<table><tr>", page->output.file);
    for (int32_t i = 0; i < count; ++i) {
        fputs("<th>", page->output.file);
        put_escaped(page->output.file, cell[i]);
        fputs("</th>", page->output.file);
    }
    fputs("</tr>\n", page->output.file);
}

void ss_page_table_row(ss_page *page, int32_t count, const char *const *cell)
{
    fputs("<tr>", page->output.file);
    for (int32_t i = 0; i < count; ++i) {
        fputs(is_number(cell[i]) ? "<td class=\"n\">" : "<td>", page->output.file);
        put_escaped(page->output.file, cell[i]);
        fputs("</td>", page->output.file);
    }
    fputs("</tr>\n", page->output.file);
}

void ss_page_table_end(ss_page *page)
{
    fputs("</table>\n", page->output.file);
}

void ss_page_yardstick(ss_page *page, const ss_yardstick *y)
{
    ss_page_heading(page, "Machine");
    ss_page_text(page,
                 "%s, %d cores online, %s, load %.2f in the minute before this was measured. One "
                 "core, measured in this run: %.1f GFLOP/s in fused multiply-adds (float), %.1f "
                 "GB/s of memory (triad).",
                 y->processor[0] != '\0' ? y->processor : "unknown processor", y->cores, y->system,
                 y->load, y->fma_gflops, y->bandwidth_gb_s);
}

void ss_row_add(ss_row *row, const char *format, ...)
{
    if (row->count == SS_PAGE_MAX_CELLS) {
        return;
    }
    char *text = row->text[row->count];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof row->text[0], format, arguments);
    va_end(arguments);
    row->cell[row->count++] = text;
}

void ss_row_add_number(ss_row *row, double value)
{
    if (isnan(value)) {
        ss_row_add(row, "%s", "");
    } else if (fabs(value) >= 1000.0) {
        ss_row_add(row, "%.0f", value);
    } else {
        ss_row_add(row, "%.4g", value);
    }
}

/* ---- pictures ---- */

static softsim_status open_script(ss_output *script, const char *folder, const char *name,
                                  const char *terminal, const char *type, const char *style,
                                  int32_t width, int32_t height, softsim_error *error)
{
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s.gp", folder, name);
    const softsim_status status = ss_output_open(script, path, error);
    if (status == SOFTSIM_OK) {
        fprintf(script->file, "set terminal %s size %d,%d %s background rgb 'white'\n", terminal,
                width, height, style);
        fprintf(script->file, "set output '%s.%s'\n", name, type);
    }
    return status;
}

softsim_status ss_plot_open(ss_output *script, const char *folder, const char *name,
                            softsim_error *error)
{
    return ss_plot_open_sized(script, folder, name, 800, 480, error);
}

softsim_status ss_plot_open_sized(ss_output *script, const char *folder, const char *name,
                                  int32_t width, int32_t height, softsim_error *error)
{
    return open_script(script, folder, name, "svg", "svg", "dynamic font 'sans,13'", width, height,
                       error);
}

void ss_plot_key_below(FILE *script, int32_t rows)
{
    fprintf(script,
            "set key at screen 0.5, screen 0.01 center bottom horizontal maxcols 1\n"
            "set bmargin %d\n",
            rows + 5);
}

softsim_status ss_plot_open_dots(ss_output *script, const char *folder, const char *name,
                                 int32_t width, int32_t height, softsim_error *error)
{
    return open_script(script, folder, name, "pngcairo", "png", "font 'sans,12'", width, height,
                       error);
}

/* The whole file; NULL when it cannot be read or is too large. */
static unsigned char *read_file(const char *path, size_t *out_size)
{
    FILE *file = fopen(path, "rbe");
    unsigned char *data = file != NULL ? malloc(MAX_PICTURE) : NULL;
    *out_size = data != NULL ? fread(data, 1, MAX_PICTURE, file) : 0;
    const bool is_good = data != NULL && ferror(file) == 0 && *out_size < MAX_PICTURE;
    if (file != NULL) {
        fclose(file);
    }
    if (!is_good) {
        free(data);
        return NULL;
    }
    return data;
}

static void put_base64(FILE *file, const unsigned char *data, size_t size)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        const uint32_t bits = (uint32_t)data[i] << 16 |
                              (i + 1 < size ? (uint32_t)data[i + 1] << 8 : 0u) |
                              (i + 2 < size ? (uint32_t)data[i + 2] : 0u);
        fputc(digit[bits >> 18], file);
        fputc(digit[bits >> 12 & 63u], file);
        fputc(i + 1 < size ? digit[bits >> 6 & 63u] : '=', file);
        fputc(i + 2 < size ? digit[bits & 63u] : '=', file);
    }
}

softsim_status ss_page_plot(ss_page *page, ss_output *script, const char *name, const char *caption,
                            softsim_error *error)
{
    char gp[PATH_SIZE], svg[PATH_SIZE], png[PATH_SIZE], log[PATH_SIZE];
    const softsim_status status = ss_output_commit(script, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    snprintf(gp, sizeof gp, "%s.gp", name);
    snprintf(svg, sizeof svg, "%s/%s.svg", page->folder, name);
    snprintf(png, sizeof png, "%s/%s.png", page->folder, name);
    remove(svg); /* of an earlier run, which must not pass for this one's */
    remove(png);
    snprintf(log, sizeof log, "%s/%s.log", page->folder, name);
    const char *const argv[] = {"gnuplot", gp, NULL};
    const ss_child_plan plan = {
        .name = "gnuplot", .argv = argv, .folder = page->folder, .err_path = log};
    const int exit_status = ss_child_run(&plan, gnuplot_timeout_s);
    size_t size = 0;
    const char *type = "svg+xml";
    unsigned char *picture = exit_status == 0 ? read_file(svg, &size) : NULL;
    if (exit_status == 0 && picture == NULL) {
        type = "png";
        picture = read_file(png, &size);
    }
    FILE *file = page->output.file;
    if (picture != NULL) {
        remove(log);
        fputs("<figure><img alt=\"", file);
        put_escaped(file, caption);
        fprintf(file, "\" src=\"data:image/%s;base64,", type);
        put_base64(file, picture, size);
        fputs("\"><figcaption>", file);
        put_escaped(file, caption);
        fputs("</figcaption></figure>\n", file);
        free(picture);
    } else if (exit_status == 127) {
        remove(log);
        ++page->missing_pictures;
        ss_page_text(page,
                     "No picture: gnuplot is not installed. With it, `gnuplot %s` in this "
                     "folder draws: %s",
                     gp, caption);
    } else {
        ss_page_text(page, "No picture: gnuplot failed on %s; %s.log says why.", gp, name);
    }
    return SOFTSIM_OK;
}

softsim_status ss_page_close(ss_page *page, softsim_error *error)
{
    if (page->missing_pictures > 0) {
        fprintf(stderr,
                "softsim-bench: warning: %d picture%s missing from the report in %s: install "
                "gnuplot (Debian: gnuplot-nox) and run it again\n",
                page->missing_pictures, page->missing_pictures == 1 ? " is" : "s are",
                page->folder);
    }
    fputs("</body></html>\n", page->output.file);
    return ss_output_commit(&page->output, error);
}

void ss_page_abandon(ss_page *page)
{
    ss_output_abandon(&page->output);
}

/* ---- CSV ---- */

softsim_status ss_report_csv_open(ss_output *csv, const char *folder, const char *name,
                                  const char *head, softsim_error *error)
{
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s.csv", folder, name);
    const softsim_status status = ss_output_open(csv, path, error);
    if (status == SOFTSIM_OK) {
        fprintf(csv->file, "%s\n", head);
    }
    return status;
}

softsim_status ss_report_csv_write(const char *folder, const char *name, const char *head,
                                   int32_t count,
                                   void (*put_row)(FILE *file, const void *context, int32_t row),
                                   const void *context, softsim_error *error)
{
    ss_output csv;
    const softsim_status status = ss_report_csv_open(&csv, folder, name, head, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t k = 0; k < count; ++k) {
        put_row(csv.file, context, k);
    }
    return ss_output_commit(&csv, error);
}

void ss_csv_text(FILE *file, const char *text)
{
    if (strpbrk(text, ",\"\r\n") == NULL) {
        fputs(text, file);
        return;
    }
    fputc('"', file);
    for (; *text != '\0'; ++text) {
        if (*text == '"') {
            fputc('"', file);
        }
        fputc(*text, file);
    }
    fputc('"', file);
}
