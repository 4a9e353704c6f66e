#!/bin/bash
# Nothing is lost on any way the frames can take, 30 a second, with every socket's receive buffer at the kernel's
# usual 212992 bytes. The long form is a minute each.
. "$(dirname "$0")/common.sh"

frames=$([ -n "$long" ] && echo 1800 || echo 150)
film 150
# of a socket: older kernels don't show rmem_default in a network of its own
[ "$(python3 -c 'import socket as s; print(s.socket(s.AF_INET, s.SOCK_DGRAM).getsockopt(s.SOL_SOCKET, s.SO_RCVBUF))')" -le 212992 ] || exit 77
# no recv_buf_size: the kernel's default
bus=(--lcm-url "udpm://239.255.76.67:7667?ttl=0")

# pass NAME [camera argument...]: the set from camera to recorder; checks that nothing is lost.
pass() {
  local name="$1"
  shift
  start_line "${bus[@]}"
  start record "$bin/record" "${bus[@]}" --out "$scratch/$name.lcm"
  wait_log record running
  start camera_proc "$bin/camera_proc" "${bus[@]}" --set camera.source="$scratch/film" "$@"
  "$tests/probe" wait MISSION "$frames" $((frames / 30 + 30))
  stop camera_proc
  finish "$name"
}

# finish NAME: ends the set and checks its report.
finish() {
  sleep 0.5 # what is under way; the report counts what was not
  stop_line
  "$bin/report" "$scratch/$1.lcm" --out "$scratch/$1" | tail -n 3
  check_report "$scratch/$1/report.json" \
    'r["frames_lost"] == 0 and all(s["lost"] == 0 and s["kernel_drops"] == 0 for s in r["stages"].values())'
}

stop_line() {
  local name
  for name in detector_proc tracker_proc pose_proc mission_proc record; do stop "$name"; done
}

echo "ring, 640x480"
pass ring
echo "JPEG inline, 640x480"
pass jpeg --set camera.transport=jpeg

echo "JPEG inline through lcm-logger and lcm-logplayer"
start logger lcm-logger --quiet --lcm-url "udpm://239.255.76.67:7667?ttl=0" "$scratch/flight.lcm"
start camera_proc "$bin/camera_proc" "${bus[@]}" --set camera.source="$scratch/film" --set camera.transport=jpeg
"$tests/probe" wait FRAME "$frames" $((frames / 30 + 30))
stop camera_proc
stop logger INT
start_line "${bus[@]}"
start record "$bin/record" "${bus[@]}" --out "$scratch/played.lcm"
wait_log record running
start logplayer lcm-logplayer --lcm-url "udpm://239.255.76.67:7667?ttl=0" "$scratch/flight.lcm"
wait "${pid_of[logplayer]}"
finish played

echo "ring, 1280x960"
rm -r "$scratch/film"
film 30 2
pass large
