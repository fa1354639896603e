#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# SPDX-FileCopyrightText: 2026 the softsim authors
#
# lcm-spy with our message types. Builds the jar of the types when it is older than they are and
# starts the spy's main class directly: Debian's own lcm-spy wrapper passes Java an option that
# Java 17 no longer knows. While the spy opens the window of a channel at 1 kHz it counts some of its
# messages as undecodable; that is the spy's own, and ends when the window is there.
#
#   tools/lcm-spy.sh [--jar-only] [arguments of lcm-spy]
#
# The jar is kept in $XDG_CACHE_HOME/softsim (~/.cache/softsim). --jar-only prints its path and
# starts nothing.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
types=
for folder in "$here/../lcmtypes" "$here/../share/softsim/lcmtypes"; do
    if [ -f "$folder/probe_pose_t.lcm" ]; then
        types=$folder
        break
    fi
done
lcm_jar=/usr/share/java/lcm.jar
chart_jar=/usr/share/java/jchart2d.jar

jar_only=no
case "${1-}" in
--jar-only)
    jar_only=yes
    shift
    ;;
--help)
    sed -n '5,/^set /s/^# \{0,1\}//p' "$0"
    exit 0
    ;;
esac

# need WHAT PACKAGE: names every missing package in one go.
missing=
need() {
    case "$1" in
    /*) [ -f "$1" ] && return ;;
    *) command -v "$1" >/dev/null && return ;;
    esac
    echo "lcm-spy.sh: $1 is missing (package $2)" >&2
    case "$missing " in
    *" $2 "*) ;;
    *) missing="$missing $2" ;;
    esac
}
need lcm-gen liblcm-bin
need javac default-jdk-headless
need jar default-jdk-headless
need "$lcm_jar" liblcm-java
if [ "$jar_only" = no ]; then
    need java default-jre
    need "$chart_jar" libjchart2d-java
fi
if [ -n "$missing" ]; then
    echo "lcm-spy.sh: install them: apt-get install$missing" >&2
    exit 1
fi
if [ -z "$types" ]; then
    echo "lcm-spy.sh: no lcmtypes folder beside $here" >&2
    exit 1
fi

# Named by the content of the types, so that a stale jar is never used.
cache=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/softsim
key=$(cat "$types"/*.lcm | cksum | tr ' ' '-')
jar=$cache/types-$key.jar
if [ ! -f "$jar" ]; then
    mkdir -p "$cache"
    work=$(mktemp -d "$cache/types.XXXXXX")
    trap 'rm -rf "$work"' EXIT INT TERM
    lcm-gen -j --jpath "$work/java" "$types"/*.lcm
    mkdir "$work/classes"
    find "$work/java" -name '*.java' | sed 's/.*/"&"/' >"$work/sources"
    javac -nowarn -cp "$lcm_jar" -d "$work/classes" "@$work/sources"
    jar cf "$work/types.jar" -C "$work/classes" .
    mv "$work/types.jar" "$jar"
    rm -rf "$work"
    trap - EXIT INT TERM
fi
if [ "$jar_only" = yes ]; then
    echo "$jar"
    exit 0
fi
exec java -Djava.net.preferIPv4Stack=true -Xmx512m -cp "$lcm_jar:$chart_jar:$jar" lcm.spy.Spy "$@"
