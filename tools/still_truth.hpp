// The truth of a still as a line of JSON, in the form that score_ellipses.py reads.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/stills.hpp"

namespace stevedore {

/// Floor of what counts: a circle less than a quarter of whose edge is seen, or whose semi-minor axis is less
/// than 4 px (a bucket's width in the image's farthest corner from 12 m), cannot be asked of anyone. Such
/// circles are listed under "hidden".
struct TruthFloor {
  double visible_share = 0.25;
  double semi_minor_px = 4;
};

/// One line of truth.jsonl. Lengths in metres, camera axes x right, y down, z forward.
/// image, labelled, ellipses and hidden: [{u, v, a, b, alpha, whole, visible_share, occupied, platform, slot,
/// center, normal, radius}]; cargoes: [{u, v, a, b, alpha, visible_share, index, platform, slot, center,
/// axis, radius}] of the rim; gravity; height (over the platform's plane); sea_state; camera: file name.
nlohmann::ordered_json truth_of(const Still& still, const std::string& image, const std::string& camera_file);

}  // namespace stevedore
