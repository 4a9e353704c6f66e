#!/bin/bash
# A hundred whole missions in lock step, of seeds that nobody has tuned anything to: as many deliver all four as is to be
# expected where 29 of 30 do. Two to three hours on two cores, so only with STEVEDORE_LONG=1; STEVEDORE_MISSIONS=N: so many.
. "$(dirname "$0")/common.sh"
missions="${STEVEDORE_MISSIONS:-100}"
[ -n "$long" ] && [ "$missions" -gt 0 ] || { echo "only in the long form: STEVEDORE_LONG=1"; exit 77; }

commit="$(git -C "$top" rev-parse --short=8 HEAD)"
"$bin/campaign" --config "$top/config/world.yaml" --missions "$missions" --jobs "$(nproc)" --seed "$((0x$commit))" \
  --out "$scratch/campaign.jsonl" || fail "the campaign failed"
"$bin/campaign" --summary "$scratch/campaign.jsonl"
python3 - "$scratch/campaign.jsonl" <<'END' || fail "fewer deliver all four than where 29 of 30 do"
import json, math, sys
lines = [json.loads(line) for line in open(sys.argv[1])]
n, all_four, z = len(lines), sum(line["delivered"] == line["of"] for line in lines), 1.96
share = all_four / n
# Wilson's interval: its upper end
upper = (share + z * z / (2 * n) + z * math.sqrt(share * (1 - share) / n + z * z / (4 * n * n))) / (1 + z * z / n)
sys.exit(upper < 29 / 30)
END
