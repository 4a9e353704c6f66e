#include "sim_proc/world/marks.hpp"

#include <cmath>
#include <numbers>

#include "sim_proc/world/surface.hpp"

namespace stevedore::world {
namespace {

using std::numbers::pi;

/// A mark's numbers in single precision, and the pixel that is asked about.
class Coverage {
 public:
  Coverage(const Mark& mark, const PlaneView& plane, const PlaneRow& row)
      : mark_(mark),
        plane_(plane),
        row_(row),
        centre_(mark.center_deck_m.cast<float>()),
        outer_(static_cast<float>(mark.radius_m)),
        inner_(mark.shape == Mark::Shape::disc ? 0.0F : static_cast<float>(mark.radius_m - mark.width_m)),
        half_length_(static_cast<float>(mark.length_m / 2)),
        half_width_(static_cast<float>(mark.width_m / 2)),
        cosine_(static_cast<float>(std::cos(mark.angle_rad))),
        sine_(static_cast<float>(std::sin(mark.angle_rad))),
        end_cosine_(static_cast<float>(std::cos(mark.angle_rad + mark.sweep_rad))),
        end_sine_(static_cast<float>(std::sin(mark.angle_rad + mark.sweep_rad))) {}

  [[nodiscard]] float at(int u) const {
    const float x = row_.x_m[static_cast<size_t>(u)] - centre_.x(),
                y = row_.y_m[static_cast<size_t>(u)] - centre_.y();
    switch (mark_.shape) {
      case Mark::Shape::disc:
      case Mark::Shape::ring:
        return ring(u, x, y);
      case Mark::Shape::arc:
        return arc(u, x, y);
      case Mark::Shape::bar:
        return bar(u, x, y);
    }
    return 0;
  }

 private:
  /// Share of the pixel where a distance with that gradient is positive.
  [[nodiscard]] float side(int u, float distance_m, float gx, float gy) const {
    return plane_.coverage(row_, u, distance_m, gx, gy);
  }

  [[nodiscard]] float ring(int u, float x, float y) const {
    const float r = std::sqrt(x * x + y * y), gx = -x / std::max(r, 1e-6F), gy = -y / std::max(r, 1e-6F);
    const float in_outer = side(u, outer_ - r, gx, gy);
    if (inner_ <= 0 || in_outer <= 0) return in_outer;
    return in_outer - side(u, inner_ - r, gx, gy);
  }

  [[nodiscard]] float arc(int u, float x, float y) const {
    const float whole = ring(u, x, y);
    if (whole <= 0) return 0;
    // the wedge between two half planes through the centre
    const float begun = side(u, cosine_ * y - sine_ * x, -sine_, cosine_);
    const float ended = side(u, end_cosine_ * y - end_sine_ * x, -end_sine_, end_cosine_);
    return whole * (mark_.sweep_rad <= pi ? begun * (1 - ended) : 1 - (1 - begun) * ended);
  }

  [[nodiscard]] float bar(int u, float x, float y) const {
    const float along = cosine_ * x + sine_ * y, across = cosine_ * y - sine_ * x;
    const float in_width =
        side(u, across + half_width_, -sine_, cosine_) - side(u, across - half_width_, -sine_, cosine_);
    if (in_width <= 0) return 0;
    return in_width *
           (side(u, along + half_length_, cosine_, sine_) - side(u, along - half_length_, cosine_, sine_));
  }

  const Mark& mark_;
  const PlaneView& plane_;
  const PlaneRow& row_;
  Eigen::Vector2f centre_;
  float outer_, inner_, half_length_, half_width_, cosine_, sine_, end_cosine_, end_sine_;
};

PixelRect rect_of(const View& view, const Deck& deck, const Mark& mark) {
  std::vector<Eigen::Vector3d> around;
  constexpr int corners = 16;
  const double reach_m =
      mark.shape == Mark::Shape::bar ? std::hypot(mark.length_m, mark.width_m) / 2 : mark.radius_m;
  const double polygon_m = reach_m / std::cos(pi / corners);  // encloses the circle
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * pi * i / corners;
    const Eigen::Vector2d at =
        mark.center_deck_m + polygon_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    around.push_back(deck.rigid.to_ned({at.x(), at.y(), 0}));
  }
  constexpr double soft_edge_px = 2;
  return view.bounds_of(around, soft_edge_px);
}

}  // namespace

Marks::Marks(const View& view, const Deck& deck) {
  for (const Mark& mark : deck.marks) {
    const PixelRect rect = rect_of(view, deck, mark);
    if (!rect.empty()) seen_.push_back({&mark, rect});
  }
}

void Marks::paint(const PlaneView& plane, const Textures& textures, PlaneRow& row) const {
  for (const Seen& seen : seen_) {
    if (!seen.rect.has_row(row.v)) continue;
    const Coverage coverage(*seen.mark, plane, row);
    Paint paint(seen.mark->paint, textures);
    const int last = std::min(seen.rect.right, row.last);
    for (int u = std::max(seen.rect.left, row.first); u < last; ++u) {
      if (!(row.cover[static_cast<size_t>(u)] > 0)) continue;
      const float share = coverage.at(u);
      if (share > 0) paint.lay(plane, row, u, share);
    }
  }
}

}  // namespace stevedore::world
