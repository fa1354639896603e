/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bus.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/random.h"

enum { CAPACITY = 2048 }; /* records under way: half a second at 4 kHz */

struct ss_bus {
    ss_bus_config config;
    uint64_t random;
    size_t record_size;
    uint32_t head, count;
    int64_t last_arrival_ns;
    int64_t arrival_ns[CAPACITY];
    unsigned char *record; /* CAPACITY records */
};

ss_bus *ss_bus_create(const ss_bus_config *config, size_t record_size)
{
    ss_bus *bus = calloc(1, sizeof *bus);
    unsigned char *record = calloc(CAPACITY, record_size);
    if (bus == NULL || record == NULL) {
        free(bus);
        free(record);
        return NULL;
    }
    bus->config = *config;
    bus->random = config->seed;
    bus->record_size = record_size;
    bus->record = record;
    bus->last_arrival_ns = INT64_MIN;
    return bus;
}

void ss_bus_destroy(ss_bus **bus)
{
    if (*bus != NULL) {
        free((*bus)->record);
        free(*bus);
        *bus = NULL;
    }
}

bool ss_bus_send(ss_bus *bus, int64_t now_ns, const void *record)
{
    /* Four numbers for every record, used or not, so that options do not shift one another. */
    const double lost = ss_random_unit(&bus->random);
    const double odd = ss_random_unit(&bus->random);
    const double odd_ms = 5.0 + 15.0 * ss_random_unit(&bus->random);
    const double u = 1.0 - ss_random_unit(&bus->random);
    if (lost < bus->config.loss || bus->count == CAPACITY) {
        return false;
    }
    const double late_ms = bus->config.delay_ms - bus->config.jitter_ms * log(u) +
                           (odd < bus->config.outlier ? odd_ms : 0.0);
    const int64_t arrival_ns = now_ns + (int64_t)(1e6 * late_ms);
    bus->last_arrival_ns = arrival_ns > bus->last_arrival_ns ? arrival_ns : bus->last_arrival_ns;
    const uint32_t slot = (bus->head + bus->count) % CAPACITY;
    bus->arrival_ns[slot] = bus->last_arrival_ns;
    memcpy(bus->record + slot * bus->record_size, record, bus->record_size);
    ++bus->count;
    return true;
}

int64_t ss_bus_due(const ss_bus *bus)
{
    return bus->count > 0 ? bus->arrival_ns[bus->head] : INT64_MAX;
}

bool ss_bus_receive(ss_bus *bus, int64_t now_ns, void *out_record)
{
    if (ss_bus_due(bus) > now_ns || bus->count == 0) {
        return false;
    }
    memcpy(out_record, bus->record + bus->head * bus->record_size, bus->record_size);
    bus->head = (bus->head + 1) % CAPACITY;
    --bus->count;
    return true;
}
