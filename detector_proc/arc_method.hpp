// The default method: arcs of edge chains, ellipses by evidence along their edges.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detector_proc/arcs.hpp"
#include "detector_proc/colour_planes.hpp"
#include "detector_proc/detector_settings.hpp"
#include "detector_proc/edge_chains.hpp"
#include "detector_proc/edge_thresholds.hpp"
#include "detector_proc/ellipse_search.hpp"
#include "detector_proc/gradient_field.hpp"
#include "detector_proc/mark_grouping.hpp"
#include "detector_proc/optics.hpp"
#include "detector_proc/sibling_search.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

/// Holds what one frame after the other can use again: memory, nothing that a result depends on.
class ArcMethod {
 public:
  std::vector<Detection> detect(const cv::Mat& image, const DetectorSettings& settings, const Optics& optics);

  /// The mark nearest to an expected one, looked for in its neighbourhood only: the same method at the
  /// size at which the mark is small. Nothing within half a semi-axis and a fifth of size: not there. Whether
  /// a circle is occupied is told where nothing in it has an edge; a rim is looked for in whole frames only.
  std::optional<Detection> detect_near(const cv::Mat& image, const Detection& expected,
                                       const DetectorSettings& settings, const Optics& optics);

 private:
  enum class Colour { unused, used };

  /// What is computed of one plane of a frame: its light, or a colour.
  struct Plane {
    GradientField field;
    EdgeThresholds thresholds;
    EdgeLinker linker;
    EdgeChains chains;
    ArcSplitter splitter;
    Arcs arcs;
    std::optional<EllipseSearch> search;
    EdgeDirections directions;
    cv::Rect window;  ///< the part of the frame that is looked at; may be empty

    /// In a part of the frame; ellipses are in the frame.
    std::vector<EllipseEdge> find_edges(const cv::Mat& image, const cv::Rect& part,
                                        const DetectorSettings& settings);
    void find_directions();
    /// Marks of this shape beyond those known.
    [[nodiscard]] std::vector<EllipseEdge> siblings_of(const Ellipse& shape,
                                                       const std::vector<Ellipse>& known) const;
  };

  /// In memory of this object's, or of the image itself where it is not reduced.
  cv::Mat reduced(const cv::Mat& image, int reduction);
  [[nodiscard]] std::vector<Detection> detections_of(const std::vector<MarkEdges>& marks,
                                                     const cv::Mat& image, int reduction,
                                                     const DetectorSettings& settings,
                                                     const Optics& optics) const;
  /// Each of one ellipse, in the light and, with colour, in the colour planes.
  std::vector<EllipseEdge> find_edges(const cv::Mat& working, bool with_colour,
                                      const DetectorSettings& settings);
  /// Where a colour has any edges, with what may belong to them.
  cv::Rect window_of(const cv::Mat& halved, cv::Size frame);
  void add_colour_edges(const cv::Mat& bgr, const DetectorSettings& settings,
                        std::vector<EllipseEdge>& edges);
  std::optional<Detection> nearest_in(const cv::Mat& image, const cv::Rect& region, const Detection& expected,
                                      Colour colour, const DetectorSettings& settings, const Optics& optics);

  /// Marks of the size of those found, in every plane looked at.
  void add_siblings(const std::vector<MarkEdges>& marks, bool with_colour, std::vector<EllipseEdge>& edges);

  Plane light_;
  std::array<cv::Mat, Opponents::count> halved_;
  GradientField halved_field_;
  EdgeLinker halved_linker_;
  EdgeChains halved_chains_;
  cv::Mat opponent_;
  std::array<Plane, Opponents::count> colour_;
  cv::Mat small_;
};

}  // namespace stevedore
