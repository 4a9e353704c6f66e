#!/bin/bash
# spy starts on the installed Java, knows the message types, and opens its window.
. "$(dirname "$0")/common.sh"

for program in xvfb-run xwininfo; do
  command -v "$program" >/dev/null || { echo "skipped: no $program (package list: full)"; exit 77; }
done

# shellcheck disable=SC2016 # expanded by the inner shell
timeout 60 xvfb-run -a sh -c '
  "$0/spy" >"$1" 2>&1 &
  spy=$!
  for i in $(seq 100); do
    if xwininfo -root -tree 2>/dev/null | grep -q "LCM Spy"; then seen=yes; break; fi
    sleep 0.2
  done
  kill "$spy"
  wait "$spy"
  [ "${seen:-}" = yes ]' "$bin" "$scratch/spy.log" || fail "no window"
if grep -i exception "$scratch/spy.log"; then fail "spy said so"; fi
