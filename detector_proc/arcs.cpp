#include "detector_proc/arcs.hpp"

#include <algorithm>
#include <cmath>

namespace stevedore {
namespace {

/// A chain turns to the other side where it does so by more than this: noise of the gradient's direction at a
/// faint edge, 8 degrees.
constexpr float hysteresis_rad = 0.14F;
/// A corner: so much within so many pixels. An ellipse of 9 by 5 px turns by 2.2 rad in 6 px at its tip; but
/// its sides are arcs of their own then, and pairs of arcs make it whole again.
constexpr float corner_rad = 0.8F;
constexpr int corner_px = 6;
/// Arcs that turn less than 25 degrees say nothing about an ellipse; of 8 px, little.
constexpr float min_turn_rad = 0.52F;
constexpr int min_length = 10;

/// Angle from g to h, to 0.3 degrees as long as it is within 50 degrees.
float angle(float gu, float gv, float hu, float hv) {
  const float dot = gu * hu + gv * hv;
  if (dot <= 0) return 0;
  const float tangent = (gu * hv - gv * hu) / dot;
  return tangent / (1 + 0.28F * tangent * tangent);
}

/// The gradient's direction along a chain, accumulated, each the mean of three neighbours.
void accumulate_turns(const short* gradient, const int* pixels, int count, std::vector<float>& turns_rad) {
  turns_rad.resize(static_cast<std::size_t>(count));
  const auto u_of = [&](int k) { return static_cast<int>(gradient[2 * pixels[k]]); };
  const auto v_of = [&](int k) { return static_cast<int>(gradient[2 * pixels[k] + 1]); };
  int u1 = u_of(0), v1 = v_of(0), u2 = u_of(1), v2 = v_of(1);  // this pixel and the next
  int u = u1 + u2, v = v1 + v2;
  float turn = 0;
  turns_rad[0] = 0;
  for (int k = 1; k < count; ++k) {
    const int last = std::min(k + 1, count - 1), u3 = u_of(last), v3 = v_of(last);
    const int next_u = u1 + u2 + u3, next_v = v1 + v2 + v3;
    turn += angle(static_cast<float>(u), static_cast<float>(v), static_cast<float>(next_u),
                  static_cast<float>(next_v));
    turns_rad[static_cast<std::size_t>(k)] = turn;
    u = next_u, v = next_v;
    u1 = u2, v1 = v2, u2 = u3, v2 = v3;
  }
}

/// The place of the edge at a pixel: the vertex of a parabola through three magnitudes along the axis that is
/// nearer to the gradient.
EdgePoint edge_point(const GradientField& field, int pixel) {
  const int width = field.magnitude.cols;
  const ushort* magnitude = field.magnitude.ptr<ushort>() + pixel;
  const short* gradient = field.gradient.ptr<short>() + 2 * pixel;
  const float gu = gradient[0], gv = gradient[1];
  const bool along_u = std::abs(gu) >= std::abs(gv);
  const int step = along_u ? 1 : width;
  const int before = magnitude[-step], here = magnitude[0], behind = magnitude[step];
  const int curvature = 2 * here - before - behind;
  const float offset =
      curvature > 0
          ? std::clamp(0.5F * static_cast<float>(behind - before) / static_cast<float>(curvature), -1.F, 1.F)
          : 0;
  const float length = std::sqrt(gu * gu + gv * gv);
  const int u_px = pixel % width, v_px = pixel / width;
  return {static_cast<float>(u_px) + (along_u ? offset : 0),
          static_cast<float>(v_px) + (along_u ? 0 : offset), gv / length, -gu / length};
}

}  // namespace

ConicSums sums_of(const std::vector<EdgePoint>& points, int begin, int end, const FitFrame& frame) {
  ConicSums sums;
  for (int k = begin; k < end; ++k) sums.add(points[static_cast<std::size_t>(k)], frame, 1, tangent_lever_px);
  return sums;
}

void ArcSplitter::split(const GradientField& field, const EdgeChains& chains, const FitFrame& frame,
                        Arcs& arcs) {
  arcs.points.clear();
  arcs.arcs.clear();
  const short* gradient = field.gradient.ptr<short>();
  for (const auto& range : chains.chains) {
    const int begin = range.begin, end = range.end;
    const int* pixels = chains.pixels.data() + begin;
    const int count = end - begin;
    accumulate_turns(gradient, pixels, count, turns_rad_);
    const auto turn = [&](int k) { return turns_rad_[static_cast<std::size_t>(k)]; };

    const auto keep = [&](int from, int to) {  // [from, to]
      const float turned = turn(to) - turn(from);
      if (to - from + 1 < min_length || std::abs(turned) < min_turn_rad) return;
      const int first = static_cast<int>(arcs.points.size());
      for (int k = from; k <= to; ++k) arcs.points.push_back(edge_point(field, pixels[k]));
      const int last = static_cast<int>(arcs.points.size());
      arcs.arcs.push_back({first, last, turned, sums_of(arcs.points, first, last, frame)});
    };

    // steady pieces between `start` and the extreme so far
    int sense = 0, start = 0, lowest = 0, highest = 0;
    const auto restart = [&](int k) { sense = 0, start = lowest = highest = k; };
    for (int k = 1; k < count; ++k) {
      const int back = std::max(start, k - corner_px);
      if (std::abs(turn(k) - turn(back)) > corner_rad) {
        // the corner's middle belongs to neither side
        const int middle = (k + back) / 2;
        if (sense != 0) keep(start, std::min(middle, sense > 0 ? highest : lowest));
        restart(middle);
        // and what has been turned so far on this side is the corner's
        k = std::max(k, middle + 1);
        continue;
      }
      if (turn(k) < turn(lowest)) lowest = k;
      if (turn(k) > turn(highest)) highest = k;
      if (sense >= 0 && turn(highest) - turn(k) > hysteresis_rad) {
        if (sense > 0) keep(start, highest);
        sense = -1, start = highest, lowest = k;
      } else if (sense <= 0 && turn(k) - turn(lowest) > hysteresis_rad) {
        if (sense < 0) keep(start, lowest);
        sense = 1, start = lowest, highest = k;
      }
    }
    if (sense != 0) keep(start, sense > 0 ? highest : lowest);
  }
}

}  // namespace stevedore
