#!/bin/bash
# The examples of docs/campaign.md as they stand there, with 4 missions of 5 s instead of 100 whole ones: two shards as
# separate processes, merged, summed up. Where GNU parallel is not installed, the lines that it would run are run by sh.
. "$(dirname "$0")/common.sh"

# example NAME: the block of docs/campaign.md, with short missions.
longest=5
[ -z "${STEVEDORE_SANITIZE:-}" ] || longest=2 # ten times as slow, and eight flights

example() {
  sed -n "/^<!-- example: $1 -->$/,/^\`\`\`$/{/^<!--\|^\`\`\`/d; p}" "$top/docs/campaign.md" |
    sed "s/--missions 100 /--missions 4 --longest $longest /"
}

# seeds_of FILE: sorted, on one line.
seeds_of() { python3 -c 'import json,sys; print(*sorted(json.loads(l)["seed"] for l in open(sys.argv[1])))' "$1"; }

mkdir "$scratch/path" "$scratch/parallel" "$scratch/slurm"
for folder in parallel slurm; do ln -s "$top/config" "$scratch/$folder/config"; done
if ! command -v parallel >/dev/null; then
  # COMMAND ::: VALUE...: what parallel --dry-run prints, run
  cat >"$scratch/path/parallel" <<'END'
#!/bin/sh
command="$1"
shift 2
for value in "$@"; do
  sh -c "$(echo "$command" | sed "s/{}/$value/g")" &
done
wait
END
  chmod +x "$scratch/path/parallel"
fi
export PATH="$bin:$scratch/path:$PATH"

example parallel >"$scratch/parallel.sh"
grep -q -e "--longest $longest .*--shard {}/2" "$scratch/parallel.sh" || fail "no example for parallel in docs/campaign.md"
(cd "$scratch/parallel" && sh -eu ../parallel.sh) >"$scratch/parallel.log" 2>&1 || fail "the example for parallel failed"
[ "$(seeds_of "$scratch/parallel/shard-1.jsonl")" = "1 3" ] || fail "shard 1 has other seeds than 1 3"
[ "$(seeds_of "$scratch/parallel/merged.jsonl")" = "1 2 3 4" ] || fail "the merged file has not every seed once"
grep -q '^missions with all delivered: 0 of 4 (0.0 %; Wilson 95 %: 0.0 to 49.0 %)$' "$scratch/parallel.log" || fail "no summary"
grep -q '4 x time is up: seed 1 2 3 4$' "$scratch/parallel.log" || fail "the causes are not counted"

example slurm >"$scratch/slurm.sh"
export SLURM_ARRAY_TASK_COUNT=2 SLURM_CPUS_PER_TASK=2
for task in 1 2; do
  (cd "$scratch/slurm" && SLURM_ARRAY_TASK_ID=$task sh -eu ../slurm.sh) >"$scratch/slurm-$task.log" 2>&1 ||
    fail "the example for Slurm failed"
done
cat "$scratch"/slurm/shard-*.jsonl >"$scratch/slurm/merged.jsonl"
[ "$(seeds_of "$scratch/slurm/merged.jsonl")" = "1 2 3 4" ] || fail "the array's files have not every seed once"

# the same missions, flown twice: the same but for what they took
for folder in parallel slurm; do sed 's/,"wall_s".*//' "$scratch/$folder/merged.jsonl" | sort >"$scratch/$folder.lines"; done
cmp "$scratch/parallel.lines" "$scratch/slurm.lines" || fail "the same seeds were flown differently"
