#!/bin/bash
# Two cargoes carried by the clock, and every deciding process killed with -9 five times on the way: both are brought,
# none twice. Four to six minutes, so only with STEVEDORE_LONG=1; SEED=N for another world.
. "$(dirname "$0")/common.sh"
[ -n "$long" ] || { echo "only in the long form: STEVEDORE_LONG=1"; exit 77; }

deciding=(gimbal_proc detector_proc tracker_proc pose_proc mission_proc)
start run "$top/run" --cargoes 2 --seed "${SEED:-1}" --report "$scratch/report"
for round in 1 2 3 4 5; do
  "$tests/probe" wait MISSION 225 120 # 15 s of flight
  echo "round $round"
  "$tests/probe" kill "${deciding[@]}" || fail "round $round: a process stayed away"
done
status=0
wait "${pid_of[run]}" || status=$?
unset "pid_of[run]"
cat "$scratch/report/table.txt"
[ $status -eq 0 ] || fail "run ended with status $status"

report="$scratch/report/report.json"
check_report "$report" 'r["delivered"] == 2 and len(r["drop_error_m"]) == 2 and r["phase"] == "complete"'
check_report "$report" 'all(r["stages"][name]["restarts"] == 5 for name in ("detector_proc", "tracker_proc", "pose_proc", "mission_proc"))'
check_report "$report" 'r["beside"]["gimbal_proc"]["restarts"] == 5'
