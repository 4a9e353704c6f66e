#!/bin/bash
# ./run as a user starts it, ended after 25 s: the mission flies, hears the operator, and since nothing is delivered by
# then the exit status says so; the report has every field, and a replay decides as was decided.
. "$(dirname "$0")/common.sh"

start run "$top/run" --seconds 25 --cargoes 2 --report "$scratch/report" >"$scratch/run.log"
"$tests/probe" wait MISSION 150 120 # 10 s of flight
"$bin/tell" hold | tee "$scratch/told" || fail "nobody heard the operator"
grep -q '^hold: ' "$scratch/told" || fail "the mission does not hold"
"$bin/tell" resume | tee "$scratch/told"
grep -q '^search: ' "$scratch/told" || fail "the mission does not resume"
status=0
wait "${pid_of[run]}" || status=$?
unset "pid_of[run]"
tail -n 20 "$scratch/run.log"
[ $status -eq 1 ] || fail "exit status $status, though nothing was delivered"
grep -q 'delivered 0/2' "$scratch/run.log" || fail "no progress of the mission was shown"

report="$scratch/report/report.json"
check_report "$report" 'r["delivered"] == 0 and r["drop_error_m"] == [] and r["attempts"] >= 0'
check_report "$report" '20 < r["flown_s"] <= r["duration_s"] < 60 and r["phase"] not in ("idle", "take-off")'
check_report "$report" 'set(r["altitude_error_below_2m_m"]) == {"p50", "p99", "max"}'
check_report "$report" 'set(r["altitude_share"]) == {"measured", "predicted", "none"}'
check_report "$report" 'isinstance(r["emergencies"], list) and r["camera_drops"] >= 0'
check_report "$report" 'r["frames_lost"] == 0 and r["messages_lost"] == 0 and r["latency_ms"]["p50"] > 0'
for file in recording.lcm table.txt evaluation.html evaluation.json overlay.mp4 mission.journal; do
  [ -s "$scratch/report/$file" ] || fail "no $file"
done
"$bin/replay" "$scratch/report/recording.lcm" --as-flown --out "$scratch/replay.lcm" || fail "the flight is not reproduced"

status=0
"$bin/tell" hold --patience 0.2 2>"$scratch/told" || status=$?
[ $status -eq 1 ] && grep -q 'mission_proc does not run' "$scratch/told" || fail "exit status $status, though nobody hears"
"$bin/tell" hold --platform 1 --slot 2 2>/dev/null && fail "a hold of a circle was taken"
true
