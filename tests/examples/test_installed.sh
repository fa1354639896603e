#!/usr/bin/env bash
# The installed tree, seen by who uses it: what the library shows, the examples by pkg-config and by
# CMake, also after the tree was moved, and a project that takes the sources in.
#   test_installed.sh SOURCE_DIR BUILD_DIR [CMake arguments of that project]
set -euo pipefail
source_dir=$1 build_dir=$2
shift 2
work=$(mktemp -d)
daemon=""
finish() {
  [ -z "$daemon" ] || { kill "$daemon" 2>/dev/null && wait "$daemon"; } || true
  rm -rf "$work"
}
trap finish EXIT
fail() { echo "test_installed: $1" >&2; exit 1; }
# quiet COMMAND...: what it says is shown when it fails.
quiet() { "$@" >"$work/said" 2>&1 || { cat "$work/said" >&2; fail "$*"; }; }

prefix=$work/first
quiet cmake --install "$build_dir" --prefix "$prefix"
for file in share/softsim/scenes/kidney.yaml share/softsim/scenes/kidney.obj share/softsim/lcmtypes/probe_pose_t.lcm \
  share/softsim/scenes/kidney-poke.lcmlog share/softsim/examples/world.c; do
  [ -f "$prefix/$file" ] || fail "$file is not installed"
done

# Of the library, what its headers declare and nothing else; each header stands by itself, in C++ too.
headers=("$prefix"/include/softsim/*.h)
grep -hoE '\bsoftsim_[a-z_]+\(' "${headers[@]}" | tr -d '(' | sort -u >"$work/declared"
library=$(echo "$prefix"/lib*/libsoftsim.so.0.1 "$prefix"/lib*/*/libsoftsim.so.0.1 | tr ' ' '\n' | grep -v '\*')
nm -D --defined-only "$library" | sed 's/.* //' | sort -u >"$work/exported"
soname=$(objdump -p "$library" | awk '$1 == "SONAME" { print $2 }')
[ "$soname" = libsoftsim.so.0.1 ] || fail "SONAME is $soname: before 1.0 a minor is an interface of its own"
diff "$work/declared" "$work/exported" || fail "< is declared, > exported"
! grep -nE 'lcm/|\<lcm_t\>|struct _softsim|softsim_[a-z_]+_t\>' "${headers[@]}" || fail "a header shows a type of LCM"
for header in "${headers[@]}"; do
  echo "#include <softsim/$(basename "$header")>" >"$work/header.c"
  quiet cc -std=c11 -Wall -Wextra -Wpedantic -Werror -I"$prefix/include" -fsyntax-only "$work/header.c"
  quiet c++ -Wall -Wextra -Werror -I"$prefix/include" -fsyntax-only -x c++ "$work/header.c"
done

# The examples of PREFIX, by pkg-config and by CMake, into FOLDER.
build_examples() {
  local prefix=$1 folder=$2 pc source
  mkdir "$folder"
  pc=$(dirname "$(find "$prefix/" -name softsim.pc)")
  for source in world client; do
    # shellcheck disable=SC2046
    quiet cc -std=c17 -Wall -Wextra -Werror "$prefix/share/softsim/examples/$source.c" -o "$folder/$source" \
      $(PKG_CONFIG_PATH=$pc pkg-config --cflags --libs softsim) -lm
  done
  quiet cmake -S "$prefix/share/softsim/examples" -B "$folder/cmake" -DCMAKE_PREFIX_PATH="$prefix"
  quiet cmake --build "$folder/cmake"
}
# What `world` says of the kidney of PREFIX; its last line is the hash.
run_world() {
  local program=$1 prefix=$2
  LD_LIBRARY_PATH=$(dirname "$(find "$prefix/" -name libsoftsim.so.0.1)") "$program" "$prefix/share/softsim/scenes/kidney.yaml"
}
build_examples "$prefix" "$work/a"
said=$(run_world "$work/a/world" "$prefix")
grep -qE '^1000 ms: [1-9]' <<<"$said" || fail "no newton is felt: $said"
[ "$said" = "$(run_world "$work/a/cmake/world" "$prefix")" ] || fail "the two builds differ"

# Moved, with the first place gone.
mkdir "$work/a folder"
mv "$prefix" "$work/a folder/second"
prefix="$work/a folder/second"
[ "$said" = "$(run_world "$work/a/world" "$prefix")" ] || fail "the moved library does not do the same"
ln -s "$prefix" "$work/second" # a compiler's command line has no blanks
build_examples "$work/second" "$work/b"
[ "$said" = "$(run_world "$work/b/cmake/world" "$prefix")" ] || fail "built against the moved tree it does not do the same"
cd "$work"
"$prefix/bin/softsim-run" "$prefix/share/softsim/scenes/kidney.yaml" --duration 0.01 --hash >/dev/null 2>&1 ||
  fail "the moved softsim-run cannot load a surface"
# A program of that name in the working directory is not the one that runs.
mkdir trap && cp "$prefix/bin/softsim-run" trap && printf '#!/bin/sh\ntouch ran\nexit 2\n' >trap/softsim-import && chmod +x trap/*
(cd trap && PATH=$prefix/bin:$PATH softsim-run "$prefix/share/softsim/scenes/kidney.yaml" --duration 0.01 >/dev/null 2>&1) ||
  fail "softsim-run by PATH cannot load a surface"
[ ! -e trap/ran ] || fail "softsim-run started a softsim-import of the working directory"

# The client against the moved server, in a network of its own.
flags=-n
[ "$(id -u)" = 0 ] || flags=-rn
if unshare $flags true 2>/dev/null; then
  # shellcheck disable=SC2016
  LD_LIBRARY_PATH=$(dirname "$(find "$prefix/" -name libsoftsim.so.0.1)") unshare $flags bash -euc '
    ip link set lo up && ip route add 224.0.0.0/4 dev lo
    coproc daemon { exec "$1/bin/softsimd" "$1/share/softsim/scenes/kidney.yaml" 2>daemon.err; }
    server=$daemon_PID
    read -r ready <&"${daemon[0]}"
    [ "$ready" = "softsimd: ready" ]
    status=0
    "$2" >client.out || status=$?
    kill "$server" && wait "$server"
    exit $status' client "$prefix" "$work/b/cmake/client" || { cat client.out daemon.err; fail "the client had no answer"; }
  grep -q '^2000 ms: ' client.out || fail "the client did not end"
  grep -qE ': [1-9][.0-9]* N' client.out || fail "the client felt nothing: $(cat client.out)"
fi

# The sources in a project of somebody else's.
mkdir theirs && cp "$prefix/share/softsim/examples/world.c" theirs
cat >theirs/CMakeLists.txt <<END
cmake_minimum_required(VERSION 3.22)
project(theirs C)
set(SOFTSIM_MODELS cnn-energy CACHE STRING "")
add_subdirectory($source_dir softsim EXCLUDE_FROM_ALL)
add_executable(world world.c)
target_link_libraries(world PRIVATE softsim::softsim m)
END
# -O0 and a block of 300 points: compiled for one second of it.
"$prefix/bin/softsim-mesh" generate block --size-mm 40,40,44.6 --points 300 --out block.obj >mesh.out
cat >block.yaml <<END
softsim: 1
object: {mesh: block.obj, units: mm, fixed: [{box_m: [[-1, -1, -1], [1, 1, -0.02]]}]}
model: {name: cnn-energy, modulus_j: 5, area_density_kg_m2: 11.5, damping_n_s_per_m3: 1725, rest_stiffness_n_per_m3: 5.0e+4}
contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 5}}}]}
END
quiet cmake -S theirs -B theirs/build -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE="-O0 -DNDEBUG" "$@"
quiet cmake --build theirs/build --target world
theirs/build/world block.yaml | grep -E '^1000 ms: [.0-9]*[1-9][.0-9]* N' >/dev/null ||
  fail "a project with the sources in it feels nothing"
echo "test_installed: $(wc -l <"$work/exported") functions, by pkg-config, CMake and add_subdirectory"
