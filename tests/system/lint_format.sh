#!/bin/bash
# scripts/lint-format is content with nothing but what clang-format said of the files.
. "$(dirname "$0")/common.sh"

mkdir "$scratch/scripts" "$scratch/path"
cp "$top/scripts/lint-format" "$scratch/scripts"
touch "$scratch/a.cpp"
for tool in sh dirname find sort xargs sed; do ln -s "$(command -v $tool)" "$scratch/path"; done

# lint STATUS WHAT: with that clang-format it ends so, and says WHAT.
lint() {
  local status=0
  PATH="$scratch/path" "$scratch/scripts/lint-format" >"$scratch/said.txt" 2>&1 || status=$?
  if [ $status -ne "$1" ] || { [ -n "$2" ] && ! grep -q "$2" "$scratch/said.txt"; }; then
    fail "status $status: $(cat "$scratch/said.txt")"
  fi
}

# formatter BODY: what stands in for clang-format.
formatter() {
  printf '#!/bin/sh\n%s\n' "$1" >"$scratch/path/clang-format"
  chmod +x "$scratch/path/clang-format"
}

lint 1 "there is no clang-format"
formatter 'echo "error: unknown key in .clang-format" >&2; exit 1'
lint 1 "unknown key"
formatter 'echo "./a.cpp:1:2: warning: code should be clang-formatted" >&2'
lint 1 "^./a.cpp$"
formatter 'exit 0'
lint 0 ""
