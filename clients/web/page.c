/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The page's files, put into the program as they are: no folder to find, none to be changed. */
#include <string.h>

#include "serve.h"

#define FILE_LIST(X)                                                                               \
    X(index, "/", "text/html; charset=utf-8", "page/index.html")                                   \
    X(script, "/app.js", "text/javascript; charset=utf-8", "dist/app.js")                          \
    X(style, "/app.css", "text/css; charset=utf-8", "page/app.css")                                \
    X(icon, "/favicon.svg", "image/svg+xml", "page/favicon.svg")

#define X(name, path, type, file)                                                                  \
    __asm__(".section .rodata\n"                                                                   \
            "ss_page_" #name "_begin: .incbin \"" SOFTSIM_WEB_DIR "/" file "\"\n"                  \
            "ss_page_" #name "_end: .byte 0\n"                                                     \
            ".previous\n");                                                                        \
    extern const unsigned char ss_page_##name##_begin[] __attribute__((visibility("hidden")));     \
    extern const unsigned char ss_page_##name##_end[] __attribute__((visibility("hidden")));
FILE_LIST(X)
#undef X

const ss_page_file *ss_page_find(const char *path)
{
    static const ss_page_file files[] = {
#define X(name, path, type, file) {path, type, ss_page_##name##_begin, ss_page_##name##_end},
        FILE_LIST(X)
#undef X
    };
    for (size_t i = 0; i < sizeof files / sizeof files[0]; ++i) {
        if (strcmp(path, files[i].path) == 0) {
            return &files[i];
        }
    }
    return NULL;
}
