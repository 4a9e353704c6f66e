#include "detector_proc/detector_stage.hpp"

#include <algorithm>
#include <cmath>

#include "lcmtypes/convert.hpp"
#include "runtime/frame_loss.hpp"

namespace stevedore {
namespace {

/// The largest so many are told. A frame of the competition has eight circles and four cargoes; what lies far
/// above is texture, and 400 of them would not fit the kernel's usual receive buffer.
constexpr size_t most_ellipses = 200;

/// So many regions cost as much as the frame.
constexpr size_t most_regions = 8;

/// Three frames at 30 Hz: further ahead a mark has left its neighbourhood.
constexpr double longest_prediction_s = 0.1;

/// Two that were expected near each other can be found in one and the same edge.
bool has(const std::vector<Detection>& found, const Detection& mark) {
  constexpr double same = 0.1;  // of the semi-minor axis: a ring's edges are a fifth of it apart
  const Ellipse& m = mark.outer.ellipse;
  return std::any_of(found.begin(), found.end(), [&m](const Detection& other) {
    const Ellipse& o = other.outer.ellipse;
    return std::hypot(o.u_px - m.u_px, o.v_px - m.v_px) < same * m.b_px &&
           std::abs(o.a_px - m.a_px) < same * m.b_px && std::abs(o.b_px - m.b_px) < same * m.b_px;
  });
}

}  // namespace

DetectorStage::DetectorStage(const DetectorSettings& settings, const std::optional<CameraModel>& camera,
                             Bus& bus, FrameReader& frames, Delivery delivery)
    : bus_(bus), frames_(frames), settings_(settings), detector_(settings, optics_of(camera)) {
  bus_.subscribe<frame_t>(
      channels::frame, [this](const frame_t& frame) { on_frame(frame); }, delivery);
  if (settings_.search == "region" && settings_.method == "arcs") {
    bus_.subscribe<tracks_t>(channels::tracks, [this](const tracks_t& tracks) { tracks_ = tracks; });
  }
}

std::optional<std::vector<Detection>> DetectorStage::search_regions(const frame_t& frame,
                                                                    const cv::Mat& image) const {
  if (!tracks_ || tracks_->header.frame_seq >= frame.header.frame_seq) return std::nullopt;
  const int64_t since_whole = frame.header.frame_seq - whole_frame_seq_;
  if (since_whole < 0 || since_whole >= settings_.full_every_frames) return std::nullopt;
  const double ahead_s = static_cast<double>(frame.header.utime - tracks_->header.utime) * 1e-6;
  if (ahead_s <= 0 || ahead_s > longest_prediction_s) return std::nullopt;
  std::vector<Detection> found;
  for (const track_t& track : tracks_->tracks) {
    if (track.status == track_t::STATUS_LOST) continue;
    if (found.size() == most_regions) return std::nullopt;
    Detection expected = from_message(track.ellipse);
    expected.outer.ellipse.u_px += track.velocity_u_pxps * ahead_s;
    expected.outer.ellipse.v_px += track.velocity_v_pxps * ahead_s;
    auto mark = detector_.detect_near(image, expected);
    if (!mark || has(found, *mark)) return std::nullopt;
    found.push_back(std::move(*mark));
  }
  if (found.empty()) return std::nullopt;
  std::stable_sort(found.begin(), found.end(), [](const Detection& a, const Detection& b) {
    return a.outer.ellipse.a_px * a.outer.ellipse.b_px > b.outer.ellipse.a_px * b.outer.ellipse.b_px;
  });
  return found;
}

void DetectorStage::on_frame(const frame_t& frame) {
  const FrameImage image = frames_.image(frame);
  if (!image) return count_frame_loss(bus_, image.fault);

  ellipses_t ellipses{};
  ellipses.header.utime = frame.header.utime;
  ellipses.header.frame_seq = frame.header.frame_seq;
  ellipses.width_px = frame.width_px;
  ellipses.height_px = frame.height_px;
  ellipses.tracks_frame_seq = -1;
  ellipses.search = ellipses_t::SEARCH_FULL;
  ellipses.method = settings_.method;
  const auto near = search_regions(frame, image.pixels);
  if (near) {
    ellipses.search = ellipses_t::SEARCH_REGION;
    ellipses.tracks_frame_seq = tracks_->header.frame_seq;
  } else {
    whole_frame_seq_ = frame.header.frame_seq;
  }
  for (const Detection& detection : near ? *near : detector_.detect(image.pixels)) {  // largest first
    if (ellipses.ellipses.size() < most_ellipses) ellipses.ellipses.push_back(to_message(detection));
  }
  ellipses.count = static_cast<int16_t>(ellipses.ellipses.size());
  bus_.publish(channels::ellipses, ellipses);
}

}  // namespace stevedore
