#!/bin/bash
# A flight recorded live is reproduced by replay, twice the same to the byte; stock lcm-logplayer feeds the processes,
# one of which is restarted half way.
. "$(dirname "$0")/common.sh"

film 150
config="$top/config/film.yaml"
start record "$bin/record" --config "$config" --out "$scratch/flight.lcm" # first: what is not recorded can't be replayed
start record_jpeg "$bin/record" --config "$config" --set record.frames=jpeg --out "$scratch/jpeg.lcm"
wait_log record running
wait_log record_jpeg running
start_line --config "$config"
start camera_proc "$bin/camera_proc" --config "$config" --set camera.source="$scratch/film"
"$tests/probe" wait MISSION 100
for name in camera_proc detector_proc tracker_proc pose_proc mission_proc record record_jpeg; do stop "$name"; done

"$bin/replay" "$scratch/flight.lcm" --config "$config" --as-flown --out "$scratch/replay-1.lcm" || fail "not as flown"
"$bin/replay" "$scratch/flight.lcm" --config "$config" --as-flown --out "$scratch/replay-2.lcm" >/dev/null
cmp "$scratch/replay-1.lcm" "$scratch/replay-2.lcm" || fail "two replays differ"
"$bin/replay" "$scratch/flight.lcm" --config "$config" --every-frame --out "$scratch/every-1.lcm" >/dev/null
"$bin/replay" "$scratch/flight.lcm" --config "$config" --every-frame --out "$scratch/every-2.lcm" >/dev/null
cmp "$scratch/every-1.lcm" "$scratch/every-2.lcm" || fail "two replays of every frame differ"

"$bin/replay" "$scratch/jpeg.lcm" --config "$config" --as-flown --out "$scratch/replay-jpeg.lcm" >"$scratch/replay-jpeg.log" ||
  fail "not as flown from JPEG"
grep -q "within tolerances" "$scratch/replay-jpeg.log" || fail "not told how it was compared"

echo "what record.frames=jpeg recorded, through lcm-logplayer"
start record_again "$bin/record" --out "$scratch/again.lcm"
wait_log record_again running
lcm-logplayer --lcm-url "udpm://239.255.76.67:7667?ttl=0" "$scratch/jpeg.lcm" >/dev/null
stop record_again
"$bin/report" "$scratch/again.lcm" --out "$scratch/again" >/dev/null
check_report "$scratch/again/report.json" 'r["missing_in_log"] == 0 and r["frames"] >= 100'

echo "lcm-logplayer into the line, the detector restarted half way"
start camera_proc "$bin/camera_proc" --config "$config" --set camera.source="$scratch/film" --set camera.transport=jpeg
start logger lcm-logger --quiet --lcm-url "udpm://239.255.76.67:7667?ttl=0" "$scratch/frames.lcm"
"$tests/probe" wait FRAME 140
stop camera_proc
stop logger INT
start_line --config "$config"
start record "$bin/record" --config "$config" --out "$scratch/played.lcm"
wait_log record running
start logplayer lcm-logplayer --speed=0.5 --lcm-url "udpm://239.255.76.67:7667?ttl=0" "$scratch/frames.lcm"
"$tests/probe" wait MISSION 50
stop detector_proc KILL
rm "$scratch/detector_proc.log"
start detector_proc "$bin/detector_proc" --config "$config"
wait_log detector_proc running
wait "${pid_of[logplayer]}"
unset "pid_of[logplayer]"
sleep 0.5
for name in detector_proc tracker_proc pose_proc mission_proc record; do stop "$name"; done
"$bin/report" "$scratch/played.lcm" --out "$scratch/played"
check_report "$scratch/played/report.json" 'r["stages"]["detector_proc"]["restarts"] == 1 and r["tracked"] >= 100'
check_report "$scratch/played/report.json" 'all(r["stages"][s]["lost"] == 0 for s in ("tracker_proc", "pose_proc", "mission_proc"))'
