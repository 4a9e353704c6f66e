#!/bin/bash
# ./run --mire2: 501 real images at 30 a second. Nothing is lost, and the large circle is what is tracked, by
# labels that were made without the detector.
. "$(dirname "$0")/common.sh"

[ -d /usr/share/visp-images-data/ViSP-images/mire-2 ] || {
  echo "skipped: package visp-images-data is not installed"
  exit 77
}
"$top/run" --mire2 --report "$scratch/report" | tail -n 11
report="$scratch/report/report.json"
check_report "$report" 'r["frames"] == 501 and r["frames_lost"] == 0'
check_report "$report" 'all(s["lost"] == 0 for s in r["stages"].values())'
"$tests/probe" targets "$scratch/report/recording.lcm" 'mire-2/image.0000.pgm' >"$scratch/targets.jsonl"
"$top/tools/score_tracks.py" "$top/tests/data/mire-2/truth.jsonl" "$scratch/targets.jsonl" | tee "$scratch/score.json"
# every labelled frame but the first, in which nothing has been chosen yet; on a busy machine a frame may be skipped
check_report "$scratch/score.json" 'r["tracked"] + r["missing"] >= r["labelled_frames"] - 1 and r["wrong"] == 0'
check_report "$report" 'r["frames_skipped"] >= '"$(value "$scratch/score.json" 'r["missing"]')"
