#!/bin/bash
# What becomes of the recording when something happens to its recorder.
. "$(dirname "$0")/common.sh"

film 30

echo "one that was killed and came back leaves one recording"
start run "$top/run" --images "$scratch/film" --rate 5 --report "$scratch/report"
recording="$scratch/report/recording.lcm"
for ((i = 0; i < 400; ++i)); do
  if [ "$(stat -c %s "$recording" 2>/dev/null || echo 0)" -gt 4000000 ]; then break; fi  # the fifth frame
  sleep 0.05
done
kill -KILL "$(cat "$scratch/report/services/record/supervise/pid")"
wait "${pid_of[run]}" || true  # the event at which it was cut is damage
[ ! -e "$scratch/report/recording.1.lcm" ] || fail "it is in pieces"
check_report "$scratch/report/report.json" '15 <= r["frames"] <= 30'
grep -q "The recorder died and came back" "$scratch/run.log" || fail "nobody was told"
