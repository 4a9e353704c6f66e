#include "detector_proc/sibling_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "detector_proc/for_each_above.hpp"

namespace stevedore {
namespace {

constexpr std::size_t directions = 256;

/// Where the edge with a given outward normal is, seen from the centre; by the normal's direction.
class Boundary {
 public:
  struct Point {
    float u, v;
  };

  explicit Boundary(const Ellipse& e) {
    const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad), a2 = e.a_px * e.a_px,
                 b2 = e.b_px * e.b_px;
    const double uu = a2 * c * c + b2 * s * s, uv = (a2 - b2) * c * s, vv = a2 * s * s + b2 * c * c;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const double t = 2 * std::numbers::pi * static_cast<double>(k) / directions;
      const double nu = std::cos(t), nv = std::sin(t), u = uu * nu + uv * nv, v = uv * nu + vv * nv;
      const double scale = 1 / std::sqrt(nu * u + nv * v);
      points_[k] = {static_cast<float>(scale * u), static_cast<float>(scale * v)};
    }
  }
  const Point& operator[](std::uint8_t direction) const { return points_[direction]; }

 private:
  std::array<Point, directions> points_{};
};

/// Sums of votes over cells; centres may lie outside the frame.
class Votes {
 public:
  Votes(cv::Size frame, const Ellipse& shape)
      : cell_px_(static_cast<float>(std::max(3.0, cell_share * shape.b_px))),
        margin_px_(static_cast<float>(shape.a_px)),
        sums_(cells_of(frame.height), cells_of(frame.width), std::uint16_t{0}) {}

  void add(float u, float v) {
    if (u < -margin_px_ || v < -margin_px_) return;
    const int i = static_cast<int>((u + margin_px_) * per_px_) + 1,
              j = static_cast<int>((v + margin_px_) * per_px_) + 1;
    if (i >= sums_.cols - 1 || j >= sums_.rows - 1) return;
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
      // the fullest of the nine; the outermost cells are empty
      for_each_above(sums_[j], sums_.cols, (least - 1) / 9, [&](int i) {
        int sum = 0, sum_u = 0, sum_v = 0;
        for (int dj = -1; dj <= 1; ++dj) {
          for (int di = -1; di <= 1; ++di) {
            const int n = sums_(j + dj, i + di);
            sum += n, sum_u += n * di, sum_v += n * dj;
          }
        }
        if (sum < least) return;
        const auto middle = [&](int k, int moment) {
          return (static_cast<float>(k) - 0.5F + static_cast<float>(moment) / static_cast<float>(sum)) *
                     cell_px_ -
                 margin_px_;
        };
        all.push_back({middle(i, sum_u), middle(j, sum_v), sum});
      });
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
  float per_px_ = 1 / cell_px_;
  cv::Mat_<std::uint16_t> sums_;
};

}  // namespace

void find_directions(const GradientField& field, const EdgeChains& chains, EdgeDirections& edges) {
  const std::size_t count = chains.pixels.size();
  edges.u_px.resize(count), edges.v_px.resize(count), edges.direction.resize(count);
  std::vector<float>&du = edges.u_px, &dv = edges.v_px;  // until they are places
  for (std::size_t k = 0; k < count; ++k) {
    const short* g = field.gradient.ptr<short>() + 2 * static_cast<std::ptrdiff_t>(chains.pixels[k]);
    du[k] = g[0], dv[k] = g[1];
  }
  if (count > 0) cv::phase(du, dv, edges.angle_rad);
  constexpr float per_rad = directions / (2 * std::numbers::pi_v<float>);
  const int width = field.magnitude.cols;
  for (std::size_t k = 0; k < count; ++k) {
    const int pixel = chains.pixels[k], row = pixel / width;
    edges.direction[k] = static_cast<std::uint8_t>(static_cast<int>(edges.angle_rad[k] * per_rad + 0.5F));
    edges.u_px[k] = static_cast<float>(pixel - row * width), edges.v_px[k] = static_cast<float>(row);
  }
}

std::vector<EllipseEdge> look_for_siblings(const Ellipse& found, const std::vector<Ellipse>& known,
                                           cv::Size frame, const EdgeDirections& edges,
                                           const EllipseSearch& search) {
  // of a long edge every few pixels will do
  constexpr double voters_round = 64;
  constexpr int farthest_apart = 8;
  const int step = std::clamp(static_cast<int>(perimeter_px(found) / voters_round), 1, farthest_apart);
  const Boundary boundary(found);
  Votes within(frame, found), without(frame, found);
  for (std::size_t k = 0; k < edges.u_px.size(); k += static_cast<std::size_t>(step)) {
    const auto [du, dv] = boundary[edges.direction[k]];
    within.add(edges.u_px[k] + du, edges.v_px[k] + dv);  // the gradient points to the bright side
    without.add(edges.u_px[k] - du, edges.v_px[k] - dv);
  }
  // a fifth of the edge: of less the place is not certain enough even where the shape is known
  const int least = std::max(1, static_cast<int>(0.2 * perimeter_px(found) / step));
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
