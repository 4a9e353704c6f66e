#include "detector_proc/detector_stage.hpp"

#include "lcmtypes/convert.hpp"
#include "runtime/frame_loss.hpp"

namespace stevedore {
namespace {

/// The largest so many are told. A frame of the competition has eight circles and four cargoes; what lies far
/// above is texture, and 400 of them would not fit the kernel's usual receive buffer.
constexpr size_t most_ellipses = 200;

}  // namespace

DetectorStage::DetectorStage(const DetectorSettings& settings, Bus& bus, FrameReader& frames,
                             Delivery delivery)
    : bus_(bus), frames_(frames), method_(settings.method), detector_(settings) {
  bus_.subscribe<frame_t>(
      channels::frame, [this](const frame_t& frame) { on_frame(frame); }, delivery);
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
  ellipses.method = method_;
  for (const Detection& detection : detector_.detect(image.pixels)) {  // largest first
    if (ellipses.ellipses.size() < most_ellipses) ellipses.ellipses.push_back(to_message(detection));
  }
  ellipses.count = static_cast<int16_t>(ellipses.ellipses.size());
  bus_.publish(channels::ellipses, ellipses);
}

}  // namespace stevedore
