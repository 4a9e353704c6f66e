#!/bin/bash
# ./run as a user starts it: plays a film through every process, loses nothing, reports, leaves nothing running.
. "$(dirname "$0")/common.sh"

film 90
start run "$top/run" --images "$scratch/film" --report "$scratch/report"

echo "a second one with the same folder is refused, and the first goes on"
for ((i = 0; i < 200; ++i)); do
  if [ -d "$scratch/report/services" ]; then break; fi
  sleep 0.05
done
status=0
"$top/run" --images "$scratch/film" --report "$scratch/report" >"$scratch/second.txt" 2>&1 || status=$?
if [ $status -ne 1 ] || ! grep -q "another ./run is using $scratch/report" "$scratch/second.txt"; then
  fail "status $status: $(cat "$scratch/second.txt")"
fi
wait "${pid_of[run]}" || fail "run ended with status $?"
tail -n 12 "$scratch/run.log"
report="$scratch/report/report.json"
check_report "$report" 'r["frames"] == 90 and r["frames_lost"] == 0'
check_report "$report" 'all(s["lost"] == 0 for s in r["stages"].values())'
check_report "$report" 'r["tracked"] >= 85 - r["frames_skipped"]'
check_report "$report" 'r["latency_ms"]["p50"] > 0 and len(r["stages"]) == 5'
[ -s "$scratch/report/overlay.mp4" ] || fail "no overlay video"
[ -s "$scratch/report/table.txt" ] || fail "no table"
if pgrep -f "$scratch" >/dev/null; then
  pgrep -af "$scratch" >&2
  fail "processes were left running"
fi
