#!/usr/bin/env python3
"""Scores `locate` (JSON lines) on the pictures of `scenes`: circles, cargoes, and which circles are occupied. Standard library only.

usage: score_scenes.py DIR/truth.jsonl FOUND.jsonl [--iou 0.8] [--heights 0,3,5,7,9,12] [--list FILE]

One to one: a detection is right where its overlap (intersection over union) with a truth not yet taken is at least --iou.
  circle    counts where at least --arc of its edge is seen and its semi-minor axis is at least --circle-px. On a circle below
            that (or under `hidden`) a detection is neither right nor false; every other one labelled circle is false.
  cargo     a rim counts where at least --arc of it is seen and its semi-minor axis is at least --rim-px; likewise below.
  occupied  of each circle found: must be what the truth says where the rim's semi-minor axis is, or in an empty circle would
            be, at least --rim-px; below, null is right too. `wrong` says the opposite, `untold` is null where it may not be.
Prints one JSON object: all heights, then each band. --list writes every miss and false one, a JSON line each, for looking at.
"""
import argparse
import json
import sys

from score_tracks import key, overlap

RIM_OVER_CIRCLE = 0.32  # a bucket's rim of 0.16 m, a painted circle's 0.5 m
ON_IT = 0.5             # overlap from which a detection is on a truth that does not count


def overlap_of(found, truth):
    """0 without looking where it can't be half."""
    apart = max(abs(found["u"] - truth["u"]), abs(found["v"] - truth["v"]))
    ratio = found["a"] * found["b"] / (truth["a"] * truth["b"])
    return 0.0 if apart > found["a"] + truth["a"] or not 0.4 < ratio < 2.5 else overlap(found, truth, 200)


def match(found, truths, least):
    """Pairs of indices, best overlap first, each index once."""
    pairs = sorted(((overlap_of(f, t), i, j) for i, f in enumerate(found) for j, t in enumerate(truths)), reverse=True)
    taken_found, taken_truth, out = set(), set(), []
    for share, i, j in pairs:
        if share < least:
            break
        if i not in taken_found and j not in taken_truth:
            taken_found.add(i)
            taken_truth.add(j)
            out.append((i, j))
    return out


class Count:
    def __init__(self):
        self.right, self.false, self.truths = 0, 0, 0

    def summary(self):
        precision, recall = self.right / max(1, self.right + self.false), self.right / max(1, self.truths)
        return {"F": round(2 * precision * recall / max(1e-9, precision + recall), 4), "precision": round(precision, 4),
                "recall": round(recall, 4), "truths": self.truths, "false": self.false}


class Band:
    def __init__(self):
        self.circle, self.cargo = Count(), Count()
        self.near = dict.fromkeys(("right", "wrong", "untold"), 0)
        self.far = dict.fromkeys(("right", "wrong"), 0)
        self.empty_frames = self.empty_frames_hit = 0

    def summary(self):
        near = sum(self.near.values())
        return {"circle": self.circle.summary(), "cargo": self.cargo.summary(),
                "occupied_near": {"share_right": round(self.near["right"] / max(1, near), 4), **self.near},
                "occupied_far": self.far, "frames_without_circle": self.empty_frames,
                "of_them_with_a_detection": self.empty_frames_hit}


def score_kind(count, found, truths, counts, least, note):
    """Adds to the count; returns the pairs (found, truth) that are right or on a truth that does not count."""
    solid, faint = [t for t in truths if counts(t)], [t for t in truths if not counts(t)]
    pairs = [(found[i], solid[j]) for i, j in match(found, solid, least)]
    count.right += len(pairs)
    count.truths += len(solid)
    for truth in solid:
        if not any(truth is t for _, t in pairs):
            note("missed", truth)
    left = [f for f in found if not any(f is g for g, _ in pairs)]
    excused = [(left[i], faint[j]) for i, j in match(left, faint, min(least, ON_IT))]
    for f in left:
        if not any(f is g for g, _ in excused):
            count.false += 1
            note("false", f)
    return pairs + excused


def score_occupied(band, pairs, cargoes, rim_px, note):
    for found, truth in pairs:
        rim = next((c for c in cargoes if c["platform"] == truth["platform"] and c["slot"] == truth["slot"]), None)
        size_px = rim["b"] if rim and truth["occupied"] else RIM_OVER_CIRCLE * truth["b"]
        told, near = found.get("occupied"), size_px >= rim_px
        kind = "right" if told == truth["occupied"] or (told is None and not near) else "wrong" if told is not None else "untold"
        (band.near if near else band.far)[kind] += 1
        if kind != "right":
            note("occupied " + kind, truth)


def score_frame(bands, truth, found, o, note):
    def counts(least_px):
        return lambda t: t["visible_share"] >= o.arc and t["b"] >= least_px
    circles = truth["ellipses"] + truth.get("hidden", [])
    of = {label: [f for f in found if f.get("label") == label] for label in ("circle", "cargo")}
    for band, noted in zip(bands, (note, lambda *_: None)):
        pairs = score_kind(band.circle, of["circle"], circles, counts(o.circle_px), o.iou,
                           lambda what, e: noted("circle " + what, e))
        score_kind(band.cargo, of["cargo"], truth["cargoes"], counts(o.rim_px), o.iou,
                   lambda what, e: noted("cargo " + what, e))
        score_occupied(band, [p for p in pairs if counts(o.circle_px)(p[1])], truth["cargoes"], o.rim_px, noted)
        if not circles:
            band.empty_frames += 1
            band.empty_frames_hit += bool(of["circle"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("truth")
    parser.add_argument("found")
    parser.add_argument("--iou", type=float, default=0.8)
    parser.add_argument("--arc", type=float, default=0.35, help="least share of an edge in view (0.35)")
    parser.add_argument("--circle-px", type=float, default=8, help="least semi-minor axis of a circle (8)")
    parser.add_argument("--rim-px", type=float, default=7, help="least semi-minor axis of a rim (7)")
    parser.add_argument("--heights", default="0,3,5,7,9,12.5", help="edges of the bands, in metres")
    parser.add_argument("--list", help="file for misses and false ones")
    o = parser.parse_args()
    edges = [float(h) for h in o.heights.split(",")]

    with open(o.found) as lines:
        found = {key(line["image"]).split("/")[-1]: line for line in map(json.loads, filter(str.strip, lines))}
    total, bands, notes, without_output = Band(), [Band() for _ in edges[1:]], [], 0
    with open(o.truth) as lines:
        for truth in map(json.loads, filter(str.strip, lines)):
            line = found.get(truth["image"].split("/")[-1])
            without_output += line is None
            at = next((k for k in range(len(bands)) if edges[k] <= truth["height"] < edges[k + 1]), len(bands) - 1)
            score_frame((total, bands[at]), truth, (line or {}).get("ellipses", []), o,
                        lambda what, e: notes.append({"image": truth["image"], "height": round(truth["height"], 2),
                                                      "what": what, **{k: e.get(k) for k in "u v a b alpha visible_share occupied coverage".split()}}))
    if o.list:
        with open(o.list, "w") as out:
            out.writelines(json.dumps(note) + "\n" for note in notes)
    print(json.dumps({**total.summary(), "images_without_output": without_output,
                      "by_height_m": {f"{low:g}-{high:g}": band.summary() for low, high, band in zip(edges, edges[1:], bands)}}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
