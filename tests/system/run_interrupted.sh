#!/bin/bash
# Ctrl-C ends ./run soon and with status 130 at any time, also while its set is being started.
. "$(dirname "$0")/common.sh"

film 20
mkdir "$scratch/bin"
ln -s "$bin"/* "$scratch/bin"
rm "$scratch/bin/watch"  # one that takes long to start
printf '#!/bin/sh\nsleep 3\nexec %s/watch "$@"\n' "$bin" >"$scratch/bin/watch"
chmod +x "$scratch/bin/watch"

# interrupted WHEN: Ctrl-C, which goes to all that belong to a terminal, as soon as the report folder has WHEN.
interrupted() {
  local status=0 began
  rm -rf "$scratch/report"
  # what a script starts in the background ignores Ctrl-C, unlike what a user starts
  start run python3 -c 'import os, signal, sys
signal.signal(signal.SIGINT, signal.SIG_DFL)
os.setsid()
os.execv(sys.argv[1], sys.argv[1:])' \
    /usr/bin/env STEVEDORE_BIN="$scratch/bin" "$top/run" --images "$scratch/film" --rate 2 --report "$scratch/report"
  until [ -e "$scratch/report/$1" ]; do kill -0 "${pid_of[run]}" || fail "run has ended"; done
  began=$SECONDS
  kill -INT -- "-${pid_of[run]}"
  wait "${pid_of[run]}" || status=$?
  [ $status -eq 130 ] || fail "status $status after Ctrl-C at $1"
  [ $((SECONDS - began)) -le 10 ] || fail "$((SECONDS - began)) s after Ctrl-C at $1"
}

echo "while the services are made"
interrupted services
echo "while the first of them starts"
interrupted services/record/supervise
if pgrep -f "$scratch" >/dev/null; then
  pgrep -af "$scratch" >&2
  fail "processes were left running"
fi
