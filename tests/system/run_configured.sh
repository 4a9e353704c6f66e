#!/bin/bash
# What --set says goes for all that ./run starts, and is what it keeps beside the log.
. "$(dirname "$0")/common.sh"

film 30
cp "$top/config/cameras/paper_640x480.yaml" "$scratch/first.yaml"
(cat "$scratch/first.yaml" && echo "# another one") >"$scratch/second.yaml"
(cat "$top/config/desk.yaml" && echo "camera_file: first.yaml") >"$scratch/deployed.yaml"
start run "$top/run" --images "$scratch/film" --rate 10 --report "$scratch/report" --config "$scratch/deployed.yaml" \
  --set camera_file=second.yaml --set bus.url='udpm://239.255.76.68:7668?ttl=0'
echo "the set is watched where its bus is"
wait "${pid_of[run]}" || fail "run ended with status $?"
grep -q "with --lcm-url 'udpm://239.255.76.68:7668?ttl=0'" "$scratch/run.log" || fail "nobody is told where to look in"
grep -q "frames 30/30" "$scratch/run.log" || fail "the end was not seen"

echo "the camera that flew is kept"
cmp "$scratch/second.yaml" "$scratch/report/camera.yaml" || fail "another camera was kept"
[ "$(tail -n 1 "$scratch/report/settings.txt")" = camera_file=camera.yaml ] || fail "it would not be taken"
