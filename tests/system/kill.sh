#!/bin/bash
# kill -9 of each process in turn while ./run plays: the set goes on.
. "$(dirname "$0")/common.sh"

film 150
start run "$top/run" --images "$scratch/film" --rate 15 --report "$scratch/report"
"$tests/probe" kill detector_proc tracker_proc pose_proc mission_proc camera_proc
wait "${pid_of[run]}" || fail "run ended with status $?"
report="$scratch/report/report.json"
cat "$scratch/report/table.txt"
"$bin/replay" "$scratch/report/recording.lcm" --config "$top/config/desk.yaml" --as-flown --out "$scratch/replay.lcm" ||
  fail "the flight with its restarts is not reproduced"
check_report "$report" 'all(s["restarts"] == 1 for s in r["stages"].values())'
check_report "$report" 'r["tracked"] >= 0.7 * r["frames"]'
