#include "detector_proc/arc_method.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "detector_proc/edge_owners.hpp"
#include "detector_proc/edge_thresholds.hpp"
#include "detector_proc/ellipse_search.hpp"
#include "detector_proc/mark_grouping.hpp"
#include "detector_proc/ring_search.hpp"

namespace stevedore {
namespace {

constexpr int min_chain_length = 10;

int reduction_of(cv::Size size, int working_size_px) {
  return std::max(1, std::max(size.width, size.height) / working_size_px);
}

FitFrame fit_frame(cv::Size size) {
  return {size.width / 2.0, size.height / 2.0, std::max(size.width, size.height) / 2.0};
}

Ellipse enlarged(const Ellipse& e, int factor) {
  return {(e.u_px + 0.5) * factor - 0.5, (e.v_px + 0.5) * factor - 0.5, e.a_px * factor, e.b_px * factor,
          e.alpha_rad};
}

Detection detection_of(const MarkEdges& mark, int factor) {
  Detection d;
  d.outer.ellipse = enlarged(mark.outer.ellipse, factor);
  d.outer.covariance.setIdentity();
  d.coverage = mark.outer.support.coverage();
  d.error = mark.outer.open_px / mark.outer.ellipse.b_px;
  d.kind = d.coverage > 0.8 ? Kind::whole : Kind::partial;
  d.label = mark.contained ? Label::cargo : Label::circle;
  return d;
}

}  // namespace

std::vector<Detection> ArcMethod::detect(const cv::Mat& image, const DetectorSettings& settings) {
  const int reduction = reduction_of(image.size(), settings.working_size_px);
  cv::Mat small = image;
  if (reduction > 1) {
    cv::resize(image, small_, image.size() / reduction, 0, 0, cv::INTER_AREA);
    small = small_;
  }
  compute_gradient(small, field_);
  const EdgeThresholds thresholds = edge_thresholds(field_);
  linker_.link(field_, thresholds, min_chain_length, chains_);
  const FitFrame frame = fit_frame(small.size());
  splitter_.split(field_, chains_, frame, arcs_);
  EllipseSearch search(field_, thresholds, frame, settings);
  std::vector<EllipseEdge> edges = search.search(arcs_);
  const std::size_t count = edges.size();
  for (std::size_t k = 0; k < count; ++k) {
    if (auto outer = look_outwards(edges[k], field_, thresholds, search, settings.min_ring_ratio)) {
      edges.push_back(std::move(*outer));
    }
  }
  std::vector<Detection> found;
  std::vector<MarkEdges> marks = group_rings(settle_owners(std::move(edges)), settings.min_ring_ratio);
  find_containers(marks);
  for (const MarkEdges& mark : marks) {
    found.push_back(detection_of(mark, reduction));
  }
  return found;
}

}  // namespace stevedore
