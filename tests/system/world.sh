#!/bin/bash
# ./run --world as a user starts it: every process on, the scripted pilot takes off and searches; nothing is lost, what
# the renderer could not draw is reported, the camera is held level, and the flight is reproduced from its log.
# STEVEDORE_LONG=1: first the table of docs/results.md, 60 s at each of 10, 15 and 30 Hz.
. "$(dirname "$0")/common.sh"

# fly NAME SECONDS HZ: a flight, reported in $scratch/NAME.
fly() {
  "$top/run" --world --seed 1 --seconds "$2" --rate "$3" --report "$scratch/$1" | tail -n 16
}

if [ -n "$long" ]; then
  for hz in 10 15 30; do
    fly "at-$hz" 60 "$hz"
    python3 - "$scratch/at-$hz/report.json" "$hz" <<'END_OF_PYTHON'
import json, sys
r = json.load(open(sys.argv[1]))
drops, frames = r["camera_drops"], r["frames"]
cpu = "  ".join(f"{name} {100 * share:.0f}" for name, share in r["cpu_share"].items())
print(f"{sys.argv[2]} Hz: {frames} frames, {drops} drops ({100 * drops / (frames + drops):.1f} %), "
      f"{r['frames_lost']} lost, {r['frames_skipped']} skipped, "
      f"{r['latency_ms']['p50']:.0f} ms p50, {r['latency_ms']['p99']:.0f} ms p99; CPU % of a core: {cpu}")
END_OF_PYTHON
  done
fi

fly report 15 15
report="$scratch/report/report.json"
check_report "$report" 'r["frames"] + r["camera_drops"] >= 220'
least=150 # on a busy machine too
[ -z "${STEVEDORE_SANITIZE:-}" ] || least=40 # a sanitized renderer draws five frames a second
check_report "$report" "r['frames'] >= $least"
check_report "$report" 'r["frames_lost"] == 0 and r["messages_lost"] == 0'
check_report "$report" 'r["answered"] >= r["frames"] - r["frames_skipped"] - 2'
check_report "$report" '"sim_proc" in r["stages"] and "gimbal_proc" in r["cpu_share"]'
check_report "$report" 'r["tracked"] > 20'
[ -s "$scratch/report/overlay.mp4" ] || fail "no overlay video"

"$tests/probe" world "$scratch/report/recording.lcm" || fail "the camera is not level, or truth is in other pixels"
"$bin/replay" "$scratch/report/recording.lcm" --config "$top/config/world.yaml" --as-flown --out "$scratch/replay.lcm" |
  tee "$scratch/replay.txt" || fail "the flight is not reproduced"
grep -q GIMBAL_LEVEL "$scratch/replay.txt" || fail "gimbal_proc was not replayed"
