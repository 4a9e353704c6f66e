#!/usr/bin/env python3
"""Scores the target of `locate --track` (JSON lines) against labelled ellipses. Standard library only.

usage: score_tracks.py TRUTH.jsonl TRACKS.jsonl [--iou 0.8] [--object K]

TRUTH line:  {"image": "dir/a.pgm", "labelled": true, "ellipses": [{"u","v","a","b","alpha"}]}  (semi-axes, px; rad, clockwise
             from +u); the followed object is ellipse K (0) of the line. A line with no ellipses: the object is not in sight.
TRACKS line: what `locate --track` prints; only "image" and "target" are read. Images are matched by folder and name.

A labelled frame counts as
  tracked       status "tracking" and an overlap (intersection over union) with the label of at least --iou
  inaccurate    status "tracking", on the object, but with less overlap
  wrong         status "tracking" on something else: its centre lies outside the label, or the label is much larger or smaller
                (a third of the area or less, three times or more), or the object is not in sight
  predicted, searching, lost, missing       as it says; missing: no line for that image
Frames in which the object is not in sight count only as wrong or as rightly_untracked. Prints one JSON object; exit status 1
if any frame is wrong.
"""
import argparse
import json
import math
import sys


def outline(e, corners=180):
    c, s = math.cos(e["alpha"]), math.sin(e["alpha"])
    angles = (2 * math.pi * k / corners for k in range(corners))
    return [(e["u"] + c * e["a"] * math.cos(t) - s * e["b"] * math.sin(t),
             e["v"] + s * e["a"] * math.cos(t) + c * e["b"] * math.sin(t)) for t in angles]


def chords(polygon, v):
    """Where the horizontal line at v enters and leaves a convex polygon; nothing if it misses it."""
    crossings = []
    for (u0, v0), (u1, v1) in zip(polygon, polygon[1:] + polygon[:1]):
        if (v0 <= v) != (v1 <= v):
            crossings.append(u0 + (v - v0) * (u1 - u0) / (v1 - v0))
    return (min(crossings), max(crossings)) if crossings else None


def overlap(one, other, lines=400):
    """Intersection over union by horizontal lines through both."""
    p, q = outline(one), outline(other)
    top, bottom = min(v for _, v in p + q), max(v for _, v in p + q)
    both = either = 0.0
    for k in range(lines):
        v = top + (k + 0.5) * (bottom - top) / lines
        a, b = chords(p, v), chords(q, v)
        common = max(0.0, min(a[1], b[1]) - max(a[0], b[0])) if a and b else 0.0
        both += common
        either += (a[1] - a[0] if a else 0.0) + (b[1] - b[0] if b else 0.0) - common
    return both / either if either else 0.0


def is_other_object(found, label):
    c, s = math.cos(label["alpha"]), math.sin(label["alpha"])
    du, dv = found["u"] - label["u"], found["v"] - label["v"]
    outside = ((c * du + s * dv) / label["a"]) ** 2 + ((c * dv - s * du) / label["b"]) ** 2 > 1
    ratio = found["a"] * found["b"] / (label["a"] * label["b"])
    return outside or ratio <= 1 / 3 or ratio >= 3


def key(image):
    return "/".join(image.split("/")[-2:])


def judge(target, label, least):
    """Class of one frame and its overlap, if there is one."""
    status = target.get("status", "missing")
    if label is None:
        return ("wrong" if status == "tracking" else "rightly_untracked"), None
    if status != "tracking":
        return status, None
    if is_other_object(target, label):
        return "wrong", None
    share = overlap(target, label)
    return ("tracked" if share >= least else "inaccurate"), share


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("truth")
    parser.add_argument("tracks")
    parser.add_argument("--iou", type=float, default=0.8)
    parser.add_argument("--object", type=int, default=0, help="which ellipse of a truth line is the object")
    options = parser.parse_args()

    with open(options.tracks) as lines:
        found = {key(line["image"]): line for line in map(json.loads, filter(str.strip, lines))}
    counts = dict.fromkeys(("tracked", "inaccurate", "wrong", "predicted", "searching", "lost", "missing",
                            "rightly_untracked"), 0)
    overlaps, not_tracked, ids = [], [], set()
    with open(options.truth) as lines:
        for truth in map(json.loads, filter(str.strip, lines)):
            if not truth.get("labelled", True):
                continue
            labels = truth["ellipses"]
            label = labels[options.object] if options.object < len(labels) else None
            target = found.get(key(truth["image"]), {}).get("target", {})
            kind, share = judge(target, label, options.iou)
            counts[kind] += 1
            if share is not None:
                overlaps.append(share)
            if target.get("status") == "tracking":
                ids.add(target.get("id"))
            if kind not in ("tracked", "rightly_untracked"):
                not_tracked.append([truth["image"], kind])
    frames = sum(counts.values()) - counts["rightly_untracked"]
    print(json.dumps({"labelled_frames": frames, "tracked_share": round(counts["tracked"] / max(1, frames), 4), **counts,
                      "mean_iou": round(sum(overlaps) / len(overlaps), 4) if overlaps else None,
                      "worst_iou": round(min(overlaps), 4) if overlaps else None,
                      "ids": len(ids), "not_tracked": not_tracked[:25]}))
    return 1 if counts["wrong"] else 0


if __name__ == "__main__":
    sys.exit(main())
