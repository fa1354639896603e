# SPDX-License-Identifier: BSD-3-Clause
# SPDX-FileCopyrightText: 2026 the softsim authors
#
# The hand of kidney-poke.lcmlog: reads kidney.obj (mm), writes a pose CSV at 1 kHz (m).
# A sphere of 5 mm comes down on the upper face, away from the hilum, presses 10 mm along the
# inward normal, holds, slides 20 mm along the surface at that depth, lets go, presses 8 mm
# elsewhere, lets go, and returns above the surface to where it began, free for a second. Every
# move is s(u) = u^3 (10 - 15 u + 6 u^2),
# which starts and ends without speed or acceleration.
#
# The track is the surface above the line y = track_y, from x = track_x on: point and normal every
# millimetre, by rays along -z, smoothed over the mesh's facets.

BEGIN {
    radius = 5; gap = 10            # mm: of the tool; above the surface when free
    track_x = -30; track_y = 6      # mm
    track_length = 60; reach = 4    # mm; facets are smoothed over +- reach
    # end time (s), depth of the tool's lowest point below the rest surface, place on the track (mm)
    phases = split("0.3 -10 5  1.3 10 5  2.3 10 5  4.3 10 25  4.8 10 25  5.5 -10 25  " \
                   "6.2 -10 52  7.0 8 52  7.5 8 52  8.0 -10 52  9.0 -10 5", phase, " +") / 3
    rate = 1000
}

$1 == "v" { ++vertices; x[vertices] = $2; y[vertices] = $3; z[vertices] = $4 }
$1 == "f" {
    ++triangles
    for (k = 1; k <= 3; ++k) { split($(k + 1), part, "/"); corner[triangles, k] = part[1] }
}

# Height of the surface above (px, py): the highest hit of a ray along -z.
function height(px, py,    t, a, b, c, area, u, v, w, best, h) {
    best = -1e9
    for (t = 1; t <= triangles; ++t) {
        a = corner[t, 1]; b = corner[t, 2]; c = corner[t, 3]
        area = (x[b] - x[a]) * (y[c] - y[a]) - (x[c] - x[a]) * (y[b] - y[a])
        if (area <= 0) continue # faces down
        u = ((x[b] - px) * (y[c] - py) - (x[c] - px) * (y[b] - py)) / area
        v = ((x[c] - px) * (y[a] - py) - (x[a] - px) * (y[c] - py)) / area
        w = 1 - u - v
        if (u < 0 || v < 0 || w < 0) continue
        h = u * z[a] + v * z[b] + w * z[c]
        if (h > best) best = h
    }
    if (best < -1e8) { print "kidney-poke.awk: the track leaves the mesh" > "/dev/stderr"; exit 1 }
    return best
}

function smooth(u) {
    if (u <= 0) return 0
    if (u >= 1) return 1
    return u * u * u * (10 - 15 * u + 6 * u * u)
}

# Value of a table over the track at place p (mm), by Catmull-Rom cubics: no kinks.
function at(name, p,    i, u, a, b, c, d) {
    i = int(p); u = p - i
    a = table[name, i - 1]; b = table[name, i]; c = table[name, i + 1]; d = table[name, i + 2]
    return b + u / 2 * (c - a + u * (2 * a - 5 * b + 4 * c - d + u * (3 * (b - c) + d - a)))
}

function make_track(    i, j, slope_x, slope_y, length_n) {
    for (i = -reach; i <= track_length + reach; ++i) {
        raw[i] = height(track_x + i, track_y)
        cross_slope[i] = (height(track_x + i, track_y + reach) - height(track_x + i, track_y - reach)) / (2 * reach)
    }
    for (i = 0; i <= track_length; ++i) {
        table["z", i] = 0; slope_y = 0
        for (j = -reach; j <= reach; ++j) {
            table["z", i] += raw[i + j] / (2 * reach + 1)
            slope_y += cross_slope[i + j] / (2 * reach + 1)
        }
        slope_x = (raw[i + reach] - raw[i - reach]) / (2 * reach)
        length_n = sqrt(1 + slope_x * slope_x + slope_y * slope_y)
        table["nx", i] = -slope_x / length_n
        table["ny", i] = -slope_y / length_n
        table["nz", i] = 1 / length_n
    }
}

END {
    make_track()
    print "time_s,probe,x,y,z,qw,qx,qy,qz,buttons"
    start = 0; depth0 = phase[2]; place0 = phase[3]
    for (k = 0; k < phases; ++k) {
        stop = phase[3 * k + 1]; depth1 = phase[3 * k + 2]; place1 = phase[3 * k + 3]
        for (n = int(start * rate + 0.5); n < stop * rate - 0.5; ++n) {
            s = smooth((n / rate - start) / (stop - start))
            place = place0 + s * (place1 - place0)
            out = radius - (depth0 + s * (depth1 - depth0))
            printf "%.3f,0,%.9f,%.9f,%.9f,1,0,0,0,0\n", n / rate, \
                (track_x + place + out * at("nx", place)) / 1000, \
                (track_y + out * at("ny", place)) / 1000, \
                (at("z", place) + out * at("nz", place)) / 1000
        }
        start = stop; depth0 = depth1; place0 = place1
    }
}
