#include "detector_proc/sibling_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace stevedore {
namespace {

/// Where the edge with this outward normal is, seen from the centre.
class BoundaryPoint {
 public:
  explicit BoundaryPoint(const Ellipse& e) {
    const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad), a2 = e.a_px * e.a_px,
                 b2 = e.b_px * e.b_px;
    uu_ = static_cast<float>(a2 * c * c + b2 * s * s);
    uv_ = static_cast<float>((a2 - b2) * c * s);
    vv_ = static_cast<float>(a2 * s * s + b2 * c * c);
  }
  /// nu, nv: of any length.
  [[nodiscard]] std::array<float, 2> operator()(float nu, float nv) const {
    const float u = uu_ * nu + uv_ * nv, v = uv_ * nu + vv_ * nv;
    const float scale = 1 / std::sqrt(std::max(nu * u + nv * v, 1e-6F));
    return {u * scale, v * scale};
  }

 private:
  float uu_, uv_, vv_;
};

/// Sums of votes over cells; centres may lie outside the frame.
class Votes {
 public:
  Votes(cv::Size frame, const Ellipse& shape)
      : cell_px_(static_cast<float>(std::max(3.0, cell_share * shape.b_px))),
        margin_px_(static_cast<float>(shape.a_px)),
        sums_(cells_of(frame.height), cells_of(frame.width), 0) {}

  void add(float u, float v) {
    const int i = static_cast<int>((u + margin_px_) / cell_px_) + 1,
              j = static_cast<int>((v + margin_px_) / cell_px_) + 1;
    if (u < -margin_px_ || v < -margin_px_ || i >= sums_.cols - 1 || j >= sums_.rows - 1) return;
    ++sums_(j, i);
  }

  struct Place {
    float u, v;
    int votes;
  };

  /// Places with at least so many votes in 3x3 cells, most first; none within `apart_px` of a better one.
  [[nodiscard]] std::vector<Place> best(int least, double apart_px) const {
    std::vector<Place> all, places;
    for (int j = 1; j < sums_.rows - 1; ++j) {
      for (int i = 1; i < sums_.cols - 1; ++i) {
        if (9 * sums_(j, i) < least) continue;  // the fullest of the nine
        int sum = 0, sum_u = 0, sum_v = 0;
        for (int dj = -1; dj <= 1; ++dj) {
          for (int di = -1; di <= 1; ++di) {
            const int n = sums_(j + dj, i + di);
            sum += n, sum_u += n * di, sum_v += n * dj;
          }
        }
        if (sum < least) continue;
        const auto middle = [&](int k, int moment) {
          return (static_cast<float>(k) - 0.5F + static_cast<float>(moment) / static_cast<float>(sum)) *
                     cell_px_ -
                 margin_px_;
        };
        all.push_back({middle(i, sum_u), middle(j, sum_v), sum});
      }
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const Place& a, const Place& b) { return a.votes > b.votes; });
    for (const Place& p : all) {
      const bool near_better = std::any_of(places.begin(), places.end(), [&](const Place& q) {
        return std::hypot(p.u - q.u, p.v - q.v) < apart_px;
      });
      if (!near_better) places.push_back(p);
      if (places.size() == most_places) break;
    }
    return places;
  }

 private:
  /// Directions err by 3 degrees and sizes differ by some percent from one mark to the next: a tenth of the
  /// semi-axis for 3x3 cells together.
  static constexpr double cell_share = 0.08;
  static constexpr std::size_t most_places = 8;  ///< a platform's circles, and as many that only seem so

  [[nodiscard]] int cells_of(int length_px) const {
    return static_cast<int>((static_cast<float>(length_px) + 2 * margin_px_) / cell_px_) + 3;
  }

  float cell_px_, margin_px_;
  cv::Mat_<int> sums_;
};

}  // namespace

std::vector<EllipseEdge> look_for_siblings(const Ellipse& found, const std::vector<Ellipse>& known,
                                           const GradientField& field, const EdgeChains& chains,
                                           const EllipseSearch& search) {
  const BoundaryPoint boundary(found);
  const cv::Size frame = field.magnitude.size();
  Votes within(frame, found), without(frame, found);
  for (const int pixel : chains.pixels) {
    const short* g = field.gradient.ptr<short>() + 2 * static_cast<std::ptrdiff_t>(pixel);
    const auto [du, dv] = boundary(g[0], g[1]);
    const int row = pixel / frame.width;
    const auto u = static_cast<float>(pixel - row * frame.width), v = static_cast<float>(row);
    within.add(u + du, v + dv);  // the gradient points to the bright side
    without.add(u - du, v - dv);
  }
  // a fifth of the edge: of less the place is not certain enough even where the shape is known
  const int least = static_cast<int>(0.2 * perimeter_px(found));
  std::vector<EllipseEdge> siblings;
  for (const Bright bright : {Bright::within, Bright::without}) {
    for (const auto& place : (bright == Bright::within ? within : without).best(least, found.b_px / 2)) {
      const bool is_known = std::any_of(known.begin(), known.end(), [&](const Ellipse& e) {
        return std::hypot(place.u - e.u_px, place.v - e.v_px) < 0.5 * found.b_px && e.b_px > 0.8 * found.b_px;
      });
      if (is_known) continue;
      Ellipse guess = found;
      guess.u_px = place.u;
      guess.v_px = place.v;
      if (auto edge = search.settle_like(guess, bright)) siblings.push_back(std::move(*edge));
    }
  }
  return siblings;
}

}  // namespace stevedore
