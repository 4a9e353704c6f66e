#!/bin/bash
# What goes wrong is said, counted, and survived.
. "$(dirname "$0")/common.sh"

echo "wrong configurations stop a process with file, line and key"
printf 'detector:\n  canny_lwo: 3\n' >"$scratch/bad.yaml"
status=0
"$bin/detector_proc" --config "$scratch/bad.yaml" 2>"$scratch/bad.log" || status=$?
[ $status -eq 2 ] || fail "exit status $status"
grep -q "bad.yaml:2: detector.canny_lwo" "$scratch/bad.log" || fail "said: $(cat "$scratch/bad.log")"
status=0
"$bin/camera_proc" --config "$scratch/nowhere.yaml" 2>"$scratch/bad.log" || status=$?
[ $status -eq 2 ] || fail "exit status $status"

echo "garbage on every channel is counted, and nothing dies"
film 60
start_line
start record "$bin/record" --out "$scratch/flight.lcm"
start camera_proc "$bin/camera_proc" --set camera.source="$scratch/film"
"$tests/probe" wait MISSION 5
"$tests/probe" garbage 3
for name in "${!pid_of[@]}"; do kill -0 "${pid_of[$name]}" || fail "$name died of garbage"; done
"$tests/probe" wait MISSION 10

echo "a camera whose images vanish is said to have failed, and comes back"
mv "$scratch/film" "$scratch/gone"
"$tests/probe" state camera_proc failed
mv "$scratch/gone" "$scratch/film"
"$tests/probe" state camera_proc ok
"$tests/probe" wait MISSION 10

stop camera_proc
for name in detector_proc tracker_proc pose_proc mission_proc record; do
  kill -TERM "${pid_of[$name]}"
  wait "${pid_of[$name]}" || fail "$name: exit status $? on SIGTERM"
  unset "pid_of[$name]"
done
"$bin/report" "$scratch/flight.lcm" --out "$scratch/report" >/dev/null
check_report "$scratch/report/report.json" 'r["stages"]["tracker_proc"]["lost"] > 0'

echo "a journal that can't be written ends no flight, and is told"
"$top/run" --seconds 12 --cargoes 1 --report "$scratch/flown" --set mission.journal=/nowhere/journal >"$scratch/run.log" || true
check_report "$scratch/flown/report.json" 'r["phase"] not in ("idle", "take-off") and r["stages"]["mission_proc"]["restarts"] == 0'
grep -q 'degraded: a restart would not know of this flight' "$scratch/flown/log/mission_proc.log" || fail "nobody was told"
