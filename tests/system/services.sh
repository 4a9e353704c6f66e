#!/bin/bash
# Services made with names relative to where their maker stands start, though runsv starts them elsewhere.
. "$(dirname "$0")/common.sh"

cd "$scratch"
ln -s "$bin" programs
cp "$top/config/desk.yaml" here.yaml
"$top/launch/make-services" "$top/launch/processes" desk set programs here.yaml
start runsv runsv set/services/mission_proc
ln -sf "$scratch/set/log/mission_proc.log" mission_proc.log
wait_log mission_proc running
sv -w 5 force-stop "$scratch/set/services/mission_proc" >/dev/null
stop runsv
