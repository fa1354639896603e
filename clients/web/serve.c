/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "serve.h"

#include <libwebsockets.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include "guests.h"
#include "rt/memory.h"
#include "softsim/client.h"

enum {
    LINE_SIZE = 512,
    LINES_PER_S = 400,
    LINES_BURST = 200,
    BROWSERS = 32,
    UNSENT = 16384, /* bytes for a browser that wait in the kernel */
    CHUNK = 65536,  /* bytes of a file at once */
    TAKING_S = 10,  /* for each of them */
    USED_S = 10,    /* after its last line a page is still in use */
    PATH_SIZE = 256,
    DISPLACED = 4000,    /* why a WebSocket is closed: another has its place. The page knows it */
    COOKIES_SIZE = 4096, /* as much as the library takes of a header */
    REFUSED = 1          /* of callbacks: answered already */
};

typedef struct browser browser;

struct ss_serve {
    struct lws_context *context;
    struct lws_vhost *vhost;
    ss_hub *hub;
    char host[32], token[128];
    bool is_loopback;
    int32_t port;
    struct lws *browser[BROWSERS];
    int32_t browsers;
    int64_t last_browser;
    atomic_bool is_news;
    ss_guests guests;
};

/* Of one connection; zero at first. */
struct browser {
    /* HTTP: what is left to send of a file: of the page, or of a recording */
    const unsigned char *at;
    FILE *recording; /* NULL: of the page */
    int64_t left;
    /* WebSocket */
    bool is_open;
    ss_hub_view view;
    char line[LINE_SIZE + 1];
    size_t length;
    double lines_left;
    int64_t line_ns;   /* of the last line, at first of the opening */
    bool has_said_one; /* a line */
};

/* ---- permission ---- */

/* Takes as long for every guess. */
static bool is_same(const char *a, const char *b)
{
    const size_t n = strlen(a), m = strlen(b);
    unsigned differ = n != m;
    for (size_t i = 0; i < n; ++i) {
        differ |= (unsigned)(a[i] ^ b[m > 0 ? i % m : 0]);
    }
    return differ == 0;
}

/* Of this port: cookies know hosts only. */
static void name_cookie(const ss_serve *serve, char out[32])
{
    (void)snprintf(out, 32, "softsim_%d", (int)ss_serve_port(serve));
}

/* The value of a cookie, empty where there is none. (The library's own way, 4.1.6, misses one whose
 * value is shorter than its name.) */
static void copy_cookie(struct lws *wsi, const char *name, char *out, size_t room)
{
    char all[COOKIES_SIZE] = "";
    const size_t length = strlen(name);
    out[0] = '\0';
    if (lws_hdr_copy(wsi, all, sizeof all, WSI_TOKEN_HTTP_COOKIE) < 1) {
        return;
    }
    char *at = all;
    for (char *one = strtok_r(all, "; ", &at); one != NULL; one = strtok_r(NULL, "; ", &at)) {
        if (strncmp(one, name, length) == 0 && one[length] == '=') {
            (void)snprintf(out, room, "%s", one + length + 1);
            return;
        }
    }
}

/* In the address, or in the cookie that the page came with: what it is made of, and recordings, are
 * asked for without an address of their own. */
static bool has_token(const ss_serve *serve, struct lws *wsi)
{
    char value[sizeof serve->token + 8] = "", name[32];
    if (serve->token[0] == '\0') {
        return true;
    }
    const char *given = lws_get_urlarg_by_name(wsi, "token=", value, sizeof value);
    if (given == NULL) {
        name_cookie(serve, name);
        copy_cookie(wsi, name, value, sizeof value);
        given = value;
    }
    return is_same(given, serve->token);
}

/* No script reads it, no other page sends it. */
static int add_cookie(const ss_serve *serve, struct lws *wsi, unsigned char **at,
                      unsigned char *end)
{
    char name[32], cookie[sizeof serve->token + 96];
    name_cookie(serve, name);
    const int length = snprintf(cookie, sizeof cookie, "%s=%s; Path=/; HttpOnly; SameSite=Strict",
                                name, serve->token);
    return lws_add_http_header_by_name(
        wsi, (const unsigned char *)"set-cookie:", (const unsigned char *)cookie, length, at, end);
}

/* Does HOST[:PORT] name this machine's loopback, or the address that it listens on? */
static bool is_own_name(const ss_serve *serve, const char *host)
{
    const char *const names[] = {"localhost", "127.0.0.1", serve->host};
    const size_t length = strcspn(host, ":");
    const char *port = host + length + (host[length] == ':');
    if (port[strspn(port, "0123456789")] != '\0') {
        return false;
    }
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (strlen(names[i]) == length && strncmp(host, names[i], length) == 0) {
            return true;
        }
    }
    return false;
}

/* Of this machine, and from a page of ours or from no page. */
static bool is_own_origin(const ss_serve *serve, struct lws *wsi)
{
    char host[PATH_SIZE] = "", origin[PATH_SIZE] = "";
    if (lws_hdr_copy(wsi, host, sizeof host, WSI_TOKEN_HOST) < 1 ||
        (serve->is_loopback && !is_own_name(serve, host))) {
        return false;
    }
    if (lws_hdr_total_length(wsi, WSI_TOKEN_ORIGIN) == 0) {
        return true;
    }
    static const char scheme[] = "http://";
    return lws_hdr_copy(wsi, origin, sizeof origin, WSI_TOKEN_ORIGIN) > 0 &&
           strncmp(origin, scheme, sizeof scheme - 1) == 0 &&
           strcmp(origin + sizeof scheme - 1, host) == 0;
}

/* The system takes more only when little is left of what was written before. On a slow link a new
 * frame so waits here, where the newest is sent, and not there, behind all that is old; and a file
 * is written piece by piece as it is taken, not megabytes at once with a long time between. */
static void keep_little_unsent(struct lws *wsi)
{
    const int unsent = UNSENT;
    (void)setsockopt(lws_get_socket_fd(wsi), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &unsent,
                     sizeof unsent);
}

/* ---- files ---- */

/* And closes, which the library has no way to say in the head: of requests that have come behind
 * one that was refused it (4.1.6) loses count, and goes round without sleeping. */
static int refuse(struct lws *wsi, unsigned code)
{
    (void)lws_return_http_status(wsi, code, NULL);
    return -1;
}

static void drop_file(browser *b)
{
    if (b->recording != NULL) {
        (void)fclose(b->recording);
        b->recording = NULL;
    }
    b->left = 0;
}

static int end_file(struct lws *wsi, browser *b)
{
    drop_file(b);
    return lws_http_transaction_completed(wsi) != 0 ? -1 : 0;
}

/* Sends the head of a file of `b->left` bytes. Recordings go the same way as the page: the
 * library's own (4.1.6) is cut short when who has asked for one half-closes. */
static int begin_file(const ss_serve *serve, struct lws *wsi, browser *b, const char *type)
{
    unsigned char head[LWS_PRE + 2048];
    unsigned char *at = head + LWS_PRE, *end = head + sizeof head - 1;
    static const char name[] = "content-disposition:", as_file[] = "attachment";
    if (lws_add_http_common_headers(wsi, HTTP_STATUS_OK, type, (lws_filepos_t)b->left, &at, end) !=
            0 ||
        (serve->token[0] != '\0' && add_cookie(serve, wsi, &at, end) != 0) ||
        (b->recording != NULL &&
         lws_add_http_header_by_name(wsi, (const unsigned char *)name,
                                     (const unsigned char *)as_file, (int)sizeof as_file - 1, &at,
                                     end) != 0) ||
        lws_finalize_write_http_header(wsi, head + LWS_PRE, &at, end) != 0) {
        return -1;
    }
    if (b->left == 0) {
        return end_file(wsi, b);
    }
    keep_little_unsent(wsi);
    lws_callback_on_writable(wsi);
    return 0;
}

static int send_file(ss_serve *serve, struct lws *wsi, browser *b)
{
    unsigned char chunk[LWS_PRE + CHUNK];
    if (b->left == 0) {
        return 0;
    }
    const size_t size = b->left < CHUNK ? (size_t)b->left : CHUNK;
    if (b->recording == NULL) {
        memcpy(chunk + LWS_PRE, b->at, size);
        b->at += size;
    } else if (fread(chunk + LWS_PRE, 1, size, b->recording) != size) {
        return -1;
    }
    b->left -= (int64_t)size;
    ss_guests_note(&serve->guests, wsi);
    ss_guests_note_progress(&serve->guests);
    lws_set_timeout(wsi, PENDING_TIMEOUT_HTTP_CONTENT, TAKING_S);
    const bool is_last = b->left == 0;
    if (lws_write(wsi, chunk + LWS_PRE, size, is_last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) <
        (int)size) {
        return -1;
    }
    if (is_last) {
        return end_file(wsi, b);
    }
    lws_callback_on_writable(wsi);
    return 0;
}

/* Finds what `path` names: bytes in memory, or an open recording. False where there is none. */
static bool find_file(const ss_serve *serve, const char *path, browser *b, const char **out_type)
{
    static const char recordings[] = "/recordings/";
    struct stat found;
    const ss_page_file *file = ss_page_find(path);
    if (file != NULL) {
        b->at = file->begin;
        b->left = (int64_t)(file->end - file->begin);
        *out_type = file->type;
        return true;
    }
    const char *recording = strncmp(path, recordings, sizeof recordings - 1) == 0
                                ? ss_hub_recording(serve->hub, path + sizeof recordings - 1)
                                : NULL;
    b->recording = recording != NULL ? fopen(recording, "rbe") : NULL;
    if (b->recording == NULL) {
        return false;
    }
    b->left = fstat(fileno(b->recording), &found) == 0 ? (int64_t)found.st_size : 0;
    *out_type = "application/octet-stream";
    return true;
}

static int serve_file(ss_serve *serve, struct lws *wsi, browser *b)
{
    char path[PATH_SIZE] = "";
    const char *type = NULL;
    ss_guests_note(&serve->guests, wsi);
    if (!is_own_origin(serve, wsi) || !has_token(serve, wsi)) {
        return refuse(wsi, HTTP_STATUS_FORBIDDEN);
    }
    if (lws_hdr_copy(wsi, path, sizeof path, WSI_TOKEN_GET_URI) < 1) {
        return refuse(wsi, HTTP_STATUS_METHOD_NOT_ALLOWED);
    }
    return find_file(serve, path, b, &type) ? begin_file(serve, wsi, b, type)
                                            : refuse(wsi, HTTP_STATUS_NOT_FOUND);
}

/* ---- messages of a browser ---- */

/* A number of `text` from *at on, which then stands behind it; false without one. */
static bool read_number(char **at, double *out)
{
    char *end = NULL;
    *out = strtod(*at, &end);
    const bool is_number = end != *at && (*end == ' ' || *end == '\0');
    *at = end;
    return is_number;
}

static bool aim(ss_serve *serve, browser *b, char *numbers)
{
    double value[9];
    for (int i = 0; i < 9; ++i) {
        if (!read_number(&numbers, &value[i])) {
            return false;
        }
    }
    const ss_mouse_aim aimed = {.position = {value[1], value[2], value[3]},
                                .orientation = {value[4], value[5], value[6], value[7]},
                                .is_grasping = value[8] == 1.0};
    if (*numbers != '\0' || !(value[0] >= 0.0 && value[0] < SOFTSIM_MAX_PROBES)) {
        return false;
    }
    (void)ss_hub_aim(serve->hub, &b->view, (int32_t)value[0], &aimed); /* it may be another's */
    return true;
}

static bool obey(ss_serve *serve, browser *b)
{
    static const char command[] = "command ", aim_word[] = "aim ";
    char *line = b->line;
    if (strcmp(line, "drop") == 0) {
        ss_hub_drop(serve->hub, &b->view);
        return true;
    }
    if (strcmp(line, "record 0") == 0 || strcmp(line, "record 1") == 0) {
        ss_hub_record(serve->hub, line[sizeof "record " - 1] == '1');
        return true;
    }
    if (strncmp(line, aim_word, sizeof aim_word - 1) == 0) {
        return aim(serve, b, line + sizeof aim_word - 1);
    }
    if (strncmp(line, command, sizeof command - 1) != 0) {
        return false;
    }
    char *name = line + sizeof command - 1;
    char *argument = strchr(name, ' ');
    if (argument != NULL) {
        *argument++ = '\0';
    }
    ss_hub_command(serve->hub, &b->view, name, argument != NULL ? argument : "");
    return true;
}

/* Within what one may say a second? */
static bool is_within_rate(browser *b)
{
    const int64_t now_ns = softsim_client_now_ns();
    const double earned = 1e-9 * (double)(now_ns - b->line_ns) * LINES_PER_S;
    b->lines_left = b->lines_left + earned < LINES_BURST ? b->lines_left + earned : LINES_BURST;
    b->line_ns = now_ns;
    b->has_said_one = true;
    b->lines_left -= 1.0;
    return b->lines_left >= 0.0;
}

/* With one that has lost its place. */
static int part_with(struct lws *wsi)
{
    lws_close_reason(wsi, (enum lws_close_status)DISPLACED, NULL, 0);
    return -1;
}

/* A piece of a message; -1 ends the connection. */
static int hear(ss_serve *serve, struct lws *wsi, browser *b, const char *data, size_t size)
{
    if (!b->is_open) {
        return part_with(wsi);
    }
    if (lws_frame_is_binary(wsi) || b->length + size > LINE_SIZE ||
        memchr(data, '\0', size) != NULL) {
        return -1;
    }
    ss_guests_note_progress(&serve->guests);
    memcpy(b->line + b->length, data, size);
    b->length += size;
    if (!lws_is_final_fragment(wsi) || lws_remaining_packet_payload(wsi) > 0) {
        return 0;
    }
    b->line[b->length] = '\0';
    b->length = 0;
    return is_within_rate(b) && obey(serve, b) ? 0 : -1;
}

/* ---- messages to a browser ---- */

/* One message; the next when this one has gone. A browser that does not read stays where it is. */
static int tell(ss_serve *serve, struct lws *wsi, browser *b)
{
    size_t size = 0;
    bool is_text = false;
    if (!b->is_open) {
        return part_with(wsi);
    }
    if (lws_send_pipe_choked(wsi)) {
        lws_callback_on_writable(wsi);
        return 0;
    }
    uint8_t *message = ss_hub_next(serve->hub, &b->view, LWS_PRE, &size, &is_text);
    if (message == NULL) {
        return 0;
    }
    ss_guests_note_progress(&serve->guests);
    const int written =
        lws_write(wsi, message + LWS_PRE, size, is_text ? LWS_WRITE_TEXT : LWS_WRITE_BINARY);
    free(message);
    lws_callback_on_writable(wsi);
    return written < (int)size ? -1 : 0;
}

static void close_browser(ss_serve *serve, struct lws *wsi, browser *b)
{
    if (!b->is_open) {
        return;
    }
    b->is_open = false;
    ss_hub_drop(serve->hub, &b->view);
    for (int32_t i = 0; i < serve->browsers; ++i) {
        if (serve->browser[i] == wsi) {
            serve->browser[i] = serve->browser[--serve->browsers];
            return;
        }
    }
}

/* 0: it may give way, 1: it is in use, 2: it has the hand. */
static int rank(const ss_serve *serve, const browser *b, int64_t now_ns)
{
    if (ss_hub_is_held_by(serve->hub, &b->view)) {
        return 2;
    }
    return b->has_said_one && now_ns - b->line_ns < USED_S * INT64_C(1000000000) ? 1 : 0;
}

/* In a full room the browser of the lowest rank that has said nothing for longest gives way, and is
 * a guest until it has gone. Nobody can tell a page that is only watched from a program that only
 * answers pings, so both may have to; a page that is used stays, however many come at once.
 * Rejected: to refuse the next, which 32 such programs would do to everybody for ever. */
static void make_place(ss_serve *serve)
{
    if (serve->browsers < BROWSERS) {
        return;
    }
    const int64_t now_ns = softsim_client_now_ns();
    struct lws *idle = NULL;
    int64_t idle_since_ns = 0;
    int lowest = 0;
    for (int32_t i = 0; i < BROWSERS; ++i) {
        const browser *b = lws_wsi_user(serve->browser[i]);
        const int own = rank(serve, b, now_ns);
        if (idle == NULL || own < lowest || (own == lowest && b->line_ns < idle_since_ns)) {
            idle = serve->browser[i];
            idle_since_ns = b->line_ns;
            lowest = own;
        }
    }
    close_browser(serve, idle, lws_wsi_user(idle));
    ss_guests_add(&serve->guests, idle);
    lws_callback_on_writable(idle);
}

static int open_browser(ss_serve *serve, struct lws *wsi, browser *b)
{
    make_place(serve);
    *b = (browser){.is_open = true,
                   .view = {.browser = ++serve->last_browser},
                   .lines_left = LINES_BURST,
                   .line_ns = softsim_client_now_ns()};
    serve->browser[serve->browsers++] = wsi;
    ss_guests_remove(&serve->guests, wsi);
    keep_little_unsent(wsi);
    lws_callback_on_writable(wsi);
    return 0;
}

/* 0: it may become a WebSocket. */
static int judge_upgrade(ss_serve *serve, struct lws *wsi)
{
    char path[PATH_SIZE] = "";
    unsigned code = 0;
    if (lws_hdr_copy(wsi, path, sizeof path, WSI_TOKEN_GET_URI) < 1 || strcmp(path, "/ws") != 0) {
        code = HTTP_STATUS_NOT_FOUND;
    } else if (!is_own_origin(serve, wsi) || !has_token(serve, wsi)) {
        code = HTTP_STATUS_FORBIDDEN;
    } else if (serve->hub == NULL) {
        code = HTTP_STATUS_SERVICE_UNAVAILABLE;
    }
    if (code == 0) {
        return 0;
    }
    return lws_return_http_status(wsi, code, NULL) < 0 ? -1 : REFUSED;
}

/* ---- the library ---- */

static int handle(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in,
                  size_t size)
{
    ss_serve *serve = lws_context_user(lws_get_context(wsi));
    browser *b = user;
    switch (reason) {
    case LWS_CALLBACK_FILTER_NETWORK_CONNECTION:
        ss_guests_make_room(&serve->guests);
        return 0;
    case LWS_CALLBACK_SERVER_NEW_CLIENT_INSTANTIATED:
        ss_guests_add(&serve->guests, wsi);
        return 0;
    case LWS_CALLBACK_WSI_DESTROY:
        ss_guests_remove(&serve->guests, wsi);
        return 0;
    case LWS_CALLBACK_HTTP:
        return serve_file(serve, wsi, b);
    case LWS_CALLBACK_HTTP_WRITEABLE:
        return send_file(serve, wsi, b);
    case LWS_CALLBACK_CLOSED_HTTP:
        if (b != NULL) { /* who has asked for nothing has none */
            drop_file(b);
        }
        return 0;
    case LWS_CALLBACK_HTTP_CONFIRM_UPGRADE:
        return judge_upgrade(serve, wsi);
    case LWS_CALLBACK_ESTABLISHED:
        return open_browser(serve, wsi, b);
    case LWS_CALLBACK_RECEIVE:
        return hear(serve, wsi, b, in, size);
    case LWS_CALLBACK_SERVER_WRITEABLE:
        return tell(serve, wsi, b);
    case LWS_CALLBACK_CLOSED:
        close_browser(serve, wsi, b);
        return 0;
    case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
        if (atomic_exchange(&serve->is_news, false)) {
            lws_callback_on_writable_all_protocol(serve->context, lws_get_protocol(wsi));
        }
        return 0;
    default:
        return 0;
    }
}

static const struct lws_protocols protocols[] = {{.name = "softsim",
                                                  .callback = handle,
                                                  .per_session_data_size = sizeof(browser),
                                                  .rx_buffer_size = LINE_SIZE},
                                                 {.name = NULL}};

/* One script, one style, one socket, all of ours. */
static const struct lws_protocol_vhost_options headers[] = {
    {&headers[1], NULL, "content-security-policy:",
     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
     "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
    {&headers[2], NULL, "x-content-type-options:", "nosniff"},
    {&headers[3], NULL, "x-frame-options:", "DENY"},
    {&headers[4], NULL, "cache-control:", "no-store"},
    {NULL, NULL, "referrer-policy:", "no-referrer"}};

static const lws_retry_bo_t pings = {.secs_since_valid_ping = 10, .secs_since_valid_hangup = 20};

softsim_status ss_serve_open(const ss_serve_config *config, ss_serve **out_serve,
                             softsim_error *error)
{
    *out_serve = NULL;
    ss_serve *serve = calloc(1, sizeof *serve);
    if (serve == NULL) {
        return ss_memory_fault(error);
    }
    lws_set_log_level(0, NULL);
    snprintf(serve->token, sizeof serve->token, "%s", config->token != NULL ? config->token : "");
    snprintf(serve->host, sizeof serve->host, "%s", config->host);
    serve->is_loopback = strncmp(config->host, "127.", 4) == 0;
    const struct lws_context_creation_info info = {
        .port = config->port,
        .iface = strcmp(config->host, "0.0.0.0") == 0 ? NULL : config->host,
        .protocols = protocols,
        .headers = headers,
        .user = serve,
        .gid = -1,
        .uid = -1,
        .options = LWS_SERVER_OPTION_DISABLE_IPV6 | LWS_SERVER_OPTION_EXPLICIT_VHOSTS |
                   LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND,
        .timeout_secs = 10,
        .keepalive_timeout = 10,
        .max_http_header_pool = SS_GUESTS_CONNECTIONS,
        .fd_limit_per_thread = SS_GUESTS_CONNECTIONS,
        .retry_and_idle_policy = &pings};
    serve->context = lws_create_context(&info);
    serve->vhost = serve->context != NULL ? lws_create_vhost(serve->context, &info) : NULL;
    if (serve->vhost == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_NETWORK,
                          "cannot listen on %s, port %d: is the port taken, the address this "
                          "machine's? give another --port or --host",
                          config->host, config->port);
        ss_serve_close(&serve);
        return SOFTSIM_ERROR_NETWORK;
    }
    serve->port = lws_get_vhost_listen_port(serve->vhost);
    *out_serve = serve;
    return SOFTSIM_OK;
}

void ss_serve_close(ss_serve **serve)
{
    if (*serve != NULL) {
        if ((*serve)->context != NULL) {
            lws_context_destroy((*serve)->context);
        }
        free(*serve);
        *serve = NULL;
    }
}

void ss_serve_attach(ss_serve *serve, ss_hub *hub)
{
    serve->hub = hub;
}

int32_t ss_serve_port(const ss_serve *serve)
{
    return serve->port;
}

bool ss_serve_run(ss_serve *serve)
{
    ss_guests_pace(&serve->guests);
    return lws_service(serve->context, 0) >= 0;
}

void ss_serve_wake(void *context)
{
    ss_serve *serve = context;
    atomic_store(&serve->is_news, true);
    lws_cancel_service(serve->context);
}
