#include "detector_proc/edge_chains.hpp"

#include <algorithm>
#include <cmath>

#include "detector_proc/for_each_above.hpp"

namespace stevedore {
namespace {

/// Distance of the lines on which seeds are looked for. Rows leave out no more than flat arcs that rise by
/// less than 8 px; those of a circle of 14 px radius or more are longer than 24 px and cross a column.
constexpr int row_pitch_px = 8, column_pitch_px = 24;
/// How far a seed looks ahead along its tangent to either side. On the tightest circle looked for, of 6 px,
/// the gradient turns by 37 degrees over it.
constexpr float look_ahead_px = 4;
/// Neighbours along an edge turn by less than 37 degrees: an ellipse of 9 by 5 px does so by 20 degrees at
/// most, and noise that just passes the threshold adds as much.
constexpr float min_cosine_squared = 0.64F;

struct Direction {
  float u, v;
};

/// Walks over one frame.
class Walker {
 public:
  Walker(const GradientField& field, cv::Mat& taken, int follow)
      : gradient_(field.gradient.ptr<short>()),
        magnitude_(field.magnitude.ptr<ushort>()),
        taken_(taken.ptr()),
        width_(field.magnitude.cols),
        height_(field.magnitude.rows),
        follow_(follow) {}

  [[nodiscard]] Direction gradient(int p) const {
    return {static_cast<float>(gradient_[2 * p]), static_cast<float>(gradient_[2 * p + 1])};
  }

  [[nodiscard]] bool taken(int p) const { return taken_[p] != 0; }
  void take(int p) { taken_[p] = 1; }

  /// The edge goes on to either side of the pixel.
  [[nodiscard]] bool looks_ahead(int u, int v) const {
    const Direction g = gradient(v * width_ + u);
    const float scale = look_ahead_px / std::sqrt(g.u * g.u + g.v * g.v);
    const int du = static_cast<int>(std::lrint(scale * g.v)), dv = static_cast<int>(std::lrint(-scale * g.u));
    const bool ahead = in(u + du, v + dv), behind = in(u - du, v - dv);
    if (!ahead && !behind) return false;
    // at the border one side must do
    return (!ahead || goes_on(g, (v + dv) * width_ + u + du)) &&
           (!behind || goes_on(g, (v - dv) * width_ + u - du));
  }

  /// Follows the edge from p, which is not written, along the tangent or (sense -1) against it.
  void follow(int p, float sense, std::vector<int>& pixels) {
    for (;;) {
      const Direction g = gradient(p);
      const float tu = sense * g.v, tv = -sense * g.u;
      const bool along_u = std::abs(tu) >= std::abs(tv);
      const int step = along_u ? (tu > 0 ? 1 : -1) : (tv > 0 ? width_ : -width_);
      const int side = along_u ? width_ : 1;
      int next = strongest(p + step, side);
      if (!free_edge(g, next)) {
        next = across_gap(p, g, tu, tv);
        if (next < 0) return;
      }
      take(next);
      pixels.push_back(next);
      p = next;
    }
  }

 private:
  [[nodiscard]] bool in(int u, int v) const { return u >= 1 && v >= 1 && u < width_ - 1 && v < height_ - 1; }

  [[nodiscard]] bool agree(const Direction& g, const Direction& h) const {
    const float dot = g.u * h.u + g.v * h.v;
    return dot > 0 && dot * dot > min_cosine_squared * (g.u * g.u + g.v * g.v) * (h.u * h.u + h.v * h.v);
  }

  [[nodiscard]] bool goes_on(const Direction& g, int p) const {
    return magnitude_[p] > follow_ && agree(g, gradient(p));
  }

  [[nodiscard]] bool free_edge(const Direction& g, int p) const { return taken_[p] == 0 && goes_on(g, p); }

  /// The strongest of a pixel and its two neighbours `side` away; it itself at a tie. The magnitude is 0 on
  /// the outermost pixels, so that a walk never leaves the frame.
  [[nodiscard]] int strongest(int p, int side) const {
    const int before = p - side, behind = p + side;
    int best = p;
    if (magnitude_[before] > magnitude_[best]) best = before;
    if (magnitude_[behind] > magnitude_[best]) best = behind;
    return best;
  }

  /// Beyond one or two pixels without an edge, straight ahead; -1: nothing there.
  [[nodiscard]] int across_gap(int p, const Direction& g, float tu, float tv) const {
    const float length = std::max(std::abs(tu), std::abs(tv));
    const int u = p % width_, v = p / width_;
    const bool along_u = std::abs(tu) >= std::abs(tv);
    for (int k = 2; k <= 3; ++k) {
      const int nu = u + static_cast<int>(std::lrint(static_cast<float>(k) * tu / length));
      const int nv = v + static_cast<int>(std::lrint(static_cast<float>(k) * tv / length));
      if (!in(nu, nv)) return -1;
      const int next = strongest(nv * width_ + nu, along_u ? width_ : 1);
      if (free_edge(g, next)) return next;
    }
    return -1;
  }

  const short* gradient_;
  const ushort* magnitude_;
  uchar* taken_;
  int width_, height_;
  int follow_;
};

}  // namespace

void EdgeLinker::link(const GradientField& field, const EdgeThresholds& thresholds, int min_length,
                      EdgeChains& chains) {
  const int width = field.magnitude.cols, height = field.magnitude.rows;
  taken_.create(height, width, CV_8UC1);
  taken_.setTo(0);
  chains.pixels.clear();
  chains.chains.clear();
  Walker walker(field, taken_, thresholds.follow);
  const ushort* magnitude = field.magnitude.ptr<ushort>();

  const auto start = [&](int u, int v, int across) {
    const int p = v * width + u;
    // the top of the edge's profile, of an edge that is not known yet
    if (magnitude[p] < magnitude[p - across] || magnitude[p] <= magnitude[p + across]) return;
    if (walker.taken(p) || walker.taken(p - across) || walker.taken(p + across)) return;
    if (!walker.looks_ahead(u, v)) return;
    const int begin = static_cast<int>(chains.pixels.size());
    walker.take(p);
    backward_.clear();
    walker.follow(p, -1, backward_);
    chains.pixels.insert(chains.pixels.end(), backward_.rbegin(), backward_.rend());
    chains.pixels.push_back(p);
    walker.follow(p, 1, chains.pixels);
    const int end = static_cast<int>(chains.pixels.size());
    if (end - begin >= min_length) {
      chains.chains.push_back({begin, end});
    } else {
      chains.pixels.resize(static_cast<std::size_t>(begin));
    }
  };

  for (int v = row_pitch_px / 2; v < height - 1; v += row_pitch_px) {
    for_each_above(magnitude + v * width, width, thresholds.start, [&](int u) { start(u, v, 1); });
  }
  for (int v = 1; v < height - 1; ++v) {
    const ushort* row = magnitude + v * width;
    for (int u = column_pitch_px / 2; u < width - 1; u += column_pitch_px) {
      if (row[u] > thresholds.start) start(u, v, width);
    }
  }
}

}  // namespace stevedore
