// From arcs to ellipses: candidates from single arcs, their halves and pairs, kept where the frame bears them
// out.
#pragma once

#include <array>
#include <vector>

#include "detector_proc/arcs.hpp"
#include "detector_proc/detector_settings.hpp"
#include "detector_proc/edge_support.hpp"
#include "detector_proc/edge_thresholds.hpp"
#include "detector_proc/ellipse_covariance.hpp"
#include "detector_proc/light_image.hpp"

namespace stevedore {

/// One edge of a mark: an ellipse that has been found.
struct EllipseEdge {
  Ellipse ellipse;
  Bright bright = Bright::within;
  EdgeSupport support;
  double evidence = 0;
  double open_px = 0;    ///< deviation of the edge where the fit leaves it open most
  LightWeights weights;  ///< of the plane in which it was found
};

/// What two arcs are asked first: an ellipse through an arc lies beyond its chord and on the inner side of
/// its tangents.
struct ArcHull {
  struct Line {
    float u, v, offset;  ///< u * u_px + v * v_px + offset >= 0 on the ellipse's side, in pixels
  };
  int arc;
  int length;
  float turn_rad;
  EdgePoint first, middle, last;
  std::array<Line, 3> lines;
};

class EllipseSearch {
 public:
  EllipseSearch(const GradientField& field, const EdgeThresholds& thresholds, const FitFrame& frame,
                const DetectorSettings& settings)
      : field_(field), thresholds_(thresholds), frame_(frame), settings_(settings) {}

  /// Edges that the arcs lead to, best evidence first; an arc is used once.
  std::vector<EllipseEdge> search(const Arcs& arcs);

  /// The edge near an ellipse that is about right; nothing without enough evidence.
  [[nodiscard]] std::optional<EllipseEdge> settle(const Ellipse& guess, Bright bright,
                                                  double min_log_odds) const;

  /// The same for one that has the shape of a mark that was found: that much less evidence will do.
  [[nodiscard]] std::optional<EllipseEdge> settle_like(const Ellipse& guess, Bright bright) const;

 private:
  /// Looks along an ellipse, in bands that shrink.
  struct Looks {
    struct Round {
      double share;  ///< width of the band to either side, in semi-minor axes
      int most_count;
      double slack;  ///< evidence that later rounds may still bring
    };
    std::array<Round, 3> rounds;
    double widest_band_px;
    double last_band_px;  ///< in which what is found counts
  };
  [[nodiscard]] std::optional<EllipseEdge> settle(const Ellipse& guess, Bright bright, double min_log_odds,
                                                  const Looks& looks,
                                                  const std::optional<ShapePrior>& prior) const;
  void from_single_arcs();
  void find_hulls();
  void from_pairs();
  void try_pair(int first, int second);
  [[nodiscard]] bool is_free(int arc) const;
  bool try_sums(const ConicSums& sums, Bright bright);
  [[nodiscard]] bool plausible(const Ellipse& ellipse) const;
  void keep(EllipseEdge edge);

  const GradientField& field_;
  EdgeThresholds thresholds_;
  FitFrame frame_;
  const DetectorSettings& settings_;
  const Arcs* arcs_ = nullptr;
  std::vector<int> free_;  ///< arcs that belong to no ellipse yet, longest first
  std::vector<bool> taken_;
  std::vector<ArcHull> hulls_;  ///< of the free arcs
  std::vector<EllipseEdge> found_;
};

}  // namespace stevedore
