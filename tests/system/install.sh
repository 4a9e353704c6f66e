#!/bin/bash
# What cmake --install puts down can be used from elsewhere: a program against the types, a Java class, the programs.
. "$(dirname "$0")/common.sh"

cmake --install "$(dirname "$bin")" --prefix "$scratch/usr" >/dev/null
export PKG_CONFIG_PATH="$scratch/usr/share/pkgconfig"
cat >"$scratch/user.cpp" <<'END'
#include <cstdio>
#include <stevedore/channels.hpp>
int main() {
  for (const auto& channel : stevedore::channel_table()) std::printf("%s %s\n", channel.name.c_str(), channel.type.c_str());
}
END
# shellcheck disable=SC2046 # a list of flags
g++ -std=c++20 "$scratch/user.cpp" -o "$scratch/user" $(pkg-config --cflags --libs stevedore)
"$scratch/user" | grep -qx "FRAME frame_t" || fail "the installed table lacks FRAME"
unzip -l "$(pkg-config --variable=jar stevedore)" 2>/dev/null | grep -q stevedore/frame_t.class ||
  jar tf "$(pkg-config --variable=jar stevedore)" | grep -q stevedore/frame_t.class || fail "no Java types"
"$scratch/usr/bin/locate" --help >/dev/null
[ -f "$scratch/usr/share/stevedore/config/aircraft.yaml" ] || fail "no configuration to begin with"
"$scratch/usr/bin/doctor" --channels | grep -q FRAME
ls "$(pkg-config --variable=types stevedore)/frame_t.lcm" >/dev/null
