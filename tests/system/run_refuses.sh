#!/bin/bash
# What ./run can't do is said before anything is started or removed.
. "$(dirname "$0")/common.sh"

mkdir "$scratch/images" "$scratch/theirs"

# refused WHAT [COMMAND...] -- ARGUMENT...: ./run ends with status 1 and says so.
refused() {
  local what="$1" status=0 before=()
  shift
  while [ "$1" != -- ]; do before+=("$1") && shift; done
  shift
  "${before[@]}" timeout 60 "$top/run" --images "$scratch/images" "$@" >"$scratch/run.txt" 2>&1 || status=$?
  if [ $status -ne 1 ] || ! grep -q "$what" "$scratch/run.txt"; then
    fail "status $status: $(cat "$scratch/run.txt")"
  fi
}

echo "a report folder without a name"
refused "report needs the name of a folder" -- --report ""

echo "a folder that is not a run's"
touch "$scratch/theirs/precious"
refused "was not made by ./run" -- --report "$scratch/theirs"
[ -f "$scratch/theirs/precious" ] || fail "it was emptied"

echo "a folder that can't be emptied, as one that another user made"
touch "$scratch/theirs/.made-by-run"
chmod 555 "$scratch/theirs"
refused "can't empty $scratch/theirs" setpriv --bounding-set=-dac_override,-dac_read_search -- --report "$scratch/theirs"
chmod 755 "$scratch/theirs"
