#include "detector_proc/rim_colours.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace stevedore {
namespace {

class Colours {
 public:
  void add(const RoundPatch& patch, int v, int u) {
    if (!patch.sees(v, u)) return;
    const std::uint8_t* pixel = patch.pixels.ptr(v, u);
    for (int k = 0; k < patch.pixels.channels(); ++k) ++histograms_[static_cast<std::size_t>(k)][pixel[k]];
    ++count_;
    channels_ = static_cast<std::size_t>(patch.pixels.channels());
  }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  /// Share of the samples within so many levels of a colour, in the channel where they are fewest.
  [[nodiscard]] double share_near(const PatchColour& colour, double levels) const {
    double share = 1;
    for (std::size_t k = 0; k < channels_; ++k) {
      const double level = colour[static_cast<Eigen::Index>(k)];
      const int first = std::max(0, cvCeil(level - levels)), last = std::min(255, cvFloor(level + levels));
      const int near = std::accumulate(histograms_[k].begin() + first, histograms_[k].begin() + last + 1, 0);
      share = std::min(share, static_cast<double>(near) / std::max(count_, 1));
    }
    return share;
  }
  [[nodiscard]] PatchColour median() const {
    PatchColour out = PatchColour::Zero();
    for (std::size_t k = 0; k < channels_; ++k) {
      int level = 0;
      for (int below = histograms_[k][0]; 2 * below <= count_ && level < 255;)
        below += histograms_[k][static_cast<std::size_t>(++level)];
      out[static_cast<Eigen::Index>(k)] = level;
    }
    return out;
  }

 private:
  std::array<std::array<int, 256>, 3> histograms_{};
  int count_ = 0;
  std::size_t channels_ = 0;
};

/// Levels in the channel that differs most.
double difference(const PatchColour& a, const PatchColour& b) {
  return (a - b).abs().maxCoeff();
}

constexpr int sampled_each_px = 2;  // a rim's core has some fifty samples

/// In squared circle radii.
double square_off_middle(int v, int u) {
  constexpr double middle = middle_px, unit = unit_px;
  const double x = (u - middle) / unit, y = (v - middle) / unit;
  return x * x + y * y;
}

/// Mean colour at some of a round edge's radii in one direction, of what is in view and within `farthest`
/// circle radii of the circle's middle; nothing where nothing is.
template <std::size_t N>
std::optional<PatchColour> mean_towards(const RoundPatch& patch, const RoundFit& fit, const PatchDirection& d,
                                        const std::array<float, N>& radii, double farthest) {
  PatchColour sum = PatchColour::Zero();
  int count = 0;
  for (const float radius : radii) {
    const float off = radius * static_cast<float>(fit.circle_px.z());
    const auto [u, v] = pixel_at(static_cast<float>(fit.circle_px.x()) + off * d.u,
                                 static_cast<float>(fit.circle_px.y()) + off * d.v);
    if (!patch.sees(v, u) || square_off_middle(v, u) > farthest * farthest) continue;
    for (int k = 0; k < patch.pixels.channels(); ++k) sum[k] += patch.pixels.ptr(v, u)[k];
    ++count;
  }
  if (count == 0) return std::nullopt;
  return PatchColour(sum / count);
}

/// Whether what has a core's colour goes on beyond a round edge on two opposite sides, as a stripe does. The
/// wall of a cargo is seen on one side.
bool goes_through(const RoundPatch& patch, const RoundFit& fit, const PatchColour& own,
                  const PatchColour& around, double clear) {
  constexpr std::array radii{1.40F, 1.50F, 1.60F};
  constexpr double least_levels = 24;  // of the two apart: half is three sigma of the mean of three pixels
  if (difference(own, around) < least_levels) return false;
  std::array<bool, directions> is_own{};
  for (std::size_t k = 0; k < directions; ++k) {
    const auto mean = mean_towards(patch, fit, all_directions()[k], radii, clear);
    is_own[k] = mean && difference(*mean, own) < difference(*mean, around);
  }
  constexpr std::size_t half = directions / 2;
  for (std::size_t k = 0; k < half; ++k)
    if (is_own[k] && (is_own[k + half - 1] || is_own[k + half] || is_own[(k + half + 1) % directions]))
      return true;
  return false;
}

/// Between the means just inside and just outside; nothing where either is out of view.
std::optional<double> difference_towards(const RoundPatch& patch, const RoundFit& fit,
                                         const PatchDirection& d) {
  constexpr std::array inner{0.60F, 0.68F, 0.76F, 0.84F, 0.92F};
  constexpr std::array outer{1.10F, 1.18F, 1.26F, 1.34F};
  constexpr double anywhere = 10;  // circle radii: beyond the patch
  const auto in = mean_towards(patch, fit, d, inner, anywhere);
  const auto out = mean_towards(patch, fit, d, outer, anywhere);
  if (!in || !out) return std::nullopt;
  return difference(*in, *out);
}

/// Medians of some thousand pixels have next to no noise: 8 levels are a difference that paint and ground of
/// one colour do not have in uneven light, and 12 are what blur and camera add to a mixture of two.
bool has_own_colour(const RimInside& inside) {
  constexpr double least_off_surround = 8, least_off_mixtures = 12;
  return inside.off_surround >= least_off_surround && inside.off_mixtures >= least_off_mixtures;
}

/// Where rings are painted: a circle's middle is seen to a twentieth of its radius, and a tenth off that of
/// what is smaller around the same one, seen obliquely from near by.
bool is_in_the_middle(const RoundFit& fit) {
  constexpr double middle = 0.12;
  return std::hypot(fit.circle_px.x() - middle_px, fit.circle_px.y() - middle_px) < middle * unit_px;
}

/// Than worn paint ever is, and not in the middle, where rings are painted.
bool is_rounder(const RoundFit& fit) {
  return fit.coverage >= 0.85 && fit.error < 0.12 && !is_in_the_middle(fit);
}

}  // namespace

double clear_radius(const Ellipse& circle, const std::optional<EllipseFit>& inner) {
  constexpr double of_rings = 0.72;  // few are wider
  constexpr double blur = 0.06;      // two pixels
  return inner ? std::min(of_rings, inner->ellipse.b_px / circle.b_px - blur) : of_rings;
}

CircleColours::CircleColours(const RoundPatch& patch, double clear_of_paint) : clear(clear_of_paint) {
  Colours grounds, paints;
  for (int v = 0; v < patch_px; v += sampled_each_px) {
    for (int u = 0; u < patch_px; u += sampled_each_px) {
      const double square = square_off_middle(v, u);
      if (square > 1.12 * 1.12 && square < 1.4 * 1.4) grounds.add(patch, v, u);   // clear of the edge's blur
      if (square > 0.85 * 0.85 && square < 0.95 * 0.95) paints.add(patch, v, u);  // of the thinnest ring too
    }
  }
  ground = grounds.median();
  paint = paints.median();
}

double CircleColours::off_mixtures(const PatchColour& c) const {
  const PatchColour apart = paint - ground;
  const double share = ((c - ground) * apart).sum() / std::max(1.0, apart.square().sum());
  return difference(c, ground + std::clamp(share, 0.0, 1.0) * apart);
}

RimInside inside_of(const RoundPatch& patch, const CircleColours& surface, const RoundFit& fit) {
  constexpr double least_levels = 8;  // three sigma of a noisy camera's pixel, of which several are averaged
  Colours core, surround;
  const Eigen::Vector3d& circle = fit.circle_px;
  for (int v = 0; v < patch_px; v += sampled_each_px) {
    for (int u = 0; u < patch_px; u += sampled_each_px) {
      const double du = (u - circle.x()) / circle.z(), dv = (v - circle.y()) / circle.z();
      const double square = du * du + dv * dv;
      if (square < 0.7 * 0.7) core.add(patch, v, u);
      // beyond the stroke of a painted ring, and inside the circle's own
      if (square > 1.35 * 1.35 && square_off_middle(v, u) < surface.clear * surface.clear)
        surround.add(patch, v, u);
    }
  }
  RimInside inside;
  if (core.empty() || surround.empty()) return inside;
  const PatchColour own = core.median();
  const PatchColour around = surround.median();
  inside.off_surround = difference(own, around);
  inside.like_surround = core.share_near(around, least_levels);
  if (is_in_the_middle(fit)) inside.goes_through = goes_through(patch, fit, own, around, surface.clear);
  inside.off_mixtures = surface.off_mixtures(own);
  if (!has_own_colour(inside) && !is_rounder(fit)) return inside;  // nothing would be made of the rest
  int differ = 0, looked = 0;
  for (const PatchDirection& direction : all_directions()) {
    const auto levels = difference_towards(patch, fit, direction);
    looked += levels ? 1 : 0;
    differ += levels && *levels > least_levels ? 1 : 0;
  }
  inside.two_sided = static_cast<double>(differ) / std::max(looked, 1);
  return inside;
}

bool may_be_paint(const RoundFit& fit, const RimInside& inside) {
  constexpr double most_like_surround = 0.25;
  const bool is_stripe = inside.like_surround > most_like_surround || inside.goes_through;
  return is_in_the_middle(fit) && (is_stripe || !has_own_colour(inside));
}

CargoSign sign_of_cargo(const RoundFit& fit, const RimInside& inside) {
  constexpr double least_coverage = 0.75;  // rope, handle and a side as bright as the ground hide a quarter
  constexpr double least_two_sided = 0.85;
  constexpr double most_error = 0.2;  // a pixel of the patch
  const bool other_colour = has_own_colour(inside);
  const bool is_round =
      fit.coverage >= least_coverage && fit.error < most_error && inside.two_sided >= least_two_sided;
  if (is_round && other_colour) return CargoSign::cargo;
  // a cargo as grey as a mixture of the two: if rounder than paint, and clear of what surrounds it
  const bool rounder = is_round && is_rounder(fit);
  if (rounder && inside.off_surround >= 12) return CargoSign::cargo;
  const bool half_round = fit.coverage >= half_coverage && inside.two_sided >= 0.7;
  return rounder || (other_colour && half_round) ? CargoSign::perhaps : CargoSign::none;
}

}  // namespace stevedore
