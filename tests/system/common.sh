# Sourced by the system tests: scratch folder, the set's processes by id, and checks that say what they saw.
# They run in a network of their own (launch/netns); nothing is found by name, nothing outlives the test.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
top="$(cd "$here/../.." && pwd)"
bin="${STEVEDORE_BIN:-$top/build/release/bin}"
tests="${STEVEDORE_TESTS:-$top/build/release/tests}"
export STEVEDORE_BIN="$bin"
long="${STEVEDORE_LONG:-}"
scratch="$(mktemp -d)"
declare -A pid_of=()

# shellcheck disable=SC2317 # called by the trap
cleanup() {
  local status=$?
  stop_all KILL
  if [ $status -ne 0 ] && [ $status -ne 77 ]; then
    for log in "$scratch"/*.log "$scratch"/report/log/*.log; do
      [ -s "$log" ] && { echo "-- $log"; tail -n 8 "$log"; } >&2
    done
  fi
  rm -rf "$scratch"
}
trap cleanup EXIT
trap 'exit 143' TERM INT

# start NAME PROGRAM [ARGUMENT...]: in the background, output to NAME.log.
start() {
  local name="$1"
  shift
  "$@" >>"$scratch/$name.log" 2>&1 </dev/null &
  pid_of[$name]=$!
}

# start_line [ARGUMENT...]: detector to mission, with these arguments each.
start_line() {
  local name
  for name in mission_proc pose_proc tracker_proc detector_proc; do start "$name" "$bin/$name" "$@"; done
  for name in detector_proc tracker_proc pose_proc mission_proc; do wait_log "$name" running; done
}

# wait_log NAME TEXT: until TEXT stands in NAME.log.
wait_log() {
  local i
  for ((i = 0; i < 200; ++i)); do
    grep -q "$2" "$scratch/$1.log" 2>/dev/null && return 0
    sleep 0.05
  done
  fail "$1 never said: $2"
}

stop() {
  local name="$1" signal="${2:-TERM}"
  kill -"$signal" "${pid_of[$name]}" 2>/dev/null || true
  wait "${pid_of[$name]}" 2>/dev/null || true
  unset "pid_of[$name]"
}

stop_all() {
  local name
  for name in "${!pid_of[@]}"; do kill -"${1:-TERM}" "${pid_of[$name]}" 2>/dev/null || true; done
  for name in "${!pid_of[@]}"; do wait "${pid_of[$name]}" 2>/dev/null || true; done
  pid_of=()
}

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# film N [SCALE]: N frames of the test film in $scratch/film.
film() {
  mkdir -p "$scratch/film"
  "$tests/make_film" "$scratch/film" "$@"
}

# value FILE EXPRESSION: of report.json, e.g. 'r["frames"]'.
value() { python3 -c "import json,sys; r=json.load(open(sys.argv[1])); print($2)" "$1"; }

# check_report FILE CONDITION: a Python condition on the report r.
check_report() {
  [ "$(value "$1" "$2")" = True ] || {
    cat "$1" >&2
    fail "not so in the report: $2"
  }
}
