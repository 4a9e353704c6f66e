#include "sim_proc/world/develop.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim_proc/world/dice.hpp"

namespace stevedore::world {
namespace {

using Eigen::Vector3f;

constexpr int noise_values = 1 << 16;

/// Half of a Gaussian's weights, from its middle outwards; 3 sigma hold 99.7 % of it.
std::vector<float> half_kernel(float sigma_px) {
  constexpr float no_blur_px = 0.05F;
  if (sigma_px < no_blur_px) return {1};
  const int radius = static_cast<int>(std::ceil(3 * sigma_px));
  std::vector<float> half;
  float sum = 0;
  for (int i = 0; i <= radius; ++i) {
    const float x = static_cast<float>(i) / sigma_px;
    half.push_back(std::exp(-x * x / 2));
    sum += (i == 0 ? 1.0F : 2.0F) * half.back();
  }
  for (float& weight : half) weight /= sum;
  return half;
}

/// Variance of noise is read + shot * light.
struct NoiseModel {
  float read, shot;
};

NoiseModel noise_model(float levels_at_mid_grey, const Response& response) {
  // deviation at mid grey, as light: levels over the response's slope there
  constexpr double mid_level = 0.5, tenth_of_read_noise = 0.1;
  double low = 0, high = 1;  // the light that gives mid grey, by bisection
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2;
    (level_of_light(middle, response) < mid_level ? low : high) = middle;
  }
  constexpr double step = 1e-4;
  const double slope =
      (level_of_light(low + step, response) - level_of_light(low - step, response)) / (2 * step);
  const double sigma = static_cast<double>(levels_at_mid_grey) / 255 / slope, variance = sigma * sigma;
  return {static_cast<float>(tenth_of_read_noise * variance),
          static_cast<float>((1 - tenth_of_read_noise) * variance / low)};
}

/// Rows of the shutter's picture around those that are asked for, three arrays each.
class ShutterRows {
 public:
  ShutterRows(const Darkroom& room, int first, int last, int radius, std::vector<float>& memory)
      : width_(room.picture.width), first_(first - radius), memory_(memory) {
    const int rows = last - first + 2 * radius;
    memory_.resize(static_cast<size_t>(rows) * 3 * static_cast<size_t>(width_));
    const bool still = room.motions.is_still();
    for (int v = first_; v < first_ + rows; ++v) {
      const int inside = std::clamp(v, 0, room.picture.height - 1);  // the border goes on
      const RowOut out{row(v, 0), row(v, 1), row(v, 2)};
      if (still)
        copy(room.picture, inside, out);
      else
        blur_row(room.rays, room.motions, room.picture, static_cast<float>(room.scene.eye.exposure_s), inside,
                 out);
    }
  }

  [[nodiscard]] float* row(int v, int channel) {
    return memory_.data() + static_cast<std::ptrdiff_t>((v - first_) * 3 + channel) * width_;
  }

 private:
  void copy(const Picture& picture, int v, const RowOut& out) const {
    const auto start = static_cast<std::ptrdiff_t>(v) * width_;
    std::copy_n(picture.red.data() + start, width_, out.red);
    std::copy_n(picture.green.data() + start, width_, out.green);
    std::copy_n(picture.blue.data() + start, width_, out.blue);
  }

  int width_, first_;
  std::vector<float>& memory_;
};

/// One channel of one row through the lens: out gets `width` values.
void blur_through_lens(ShutterRows& rows, int v, int channel, const std::vector<float>& half, int width,
                       std::vector<float>& padded, float* out) {
  const int radius = static_cast<int>(half.size()) - 1;
  padded.resize(static_cast<size_t>(width + 2 * radius));
  float* middle = padded.data() + radius;
  const float* here = rows.row(v, channel);
  for (int u = 0; u < width; ++u) middle[u] = half[0] * here[u];
  for (int r = 1; r <= radius; ++r) {
    const float *above = rows.row(v - r, channel), *below = rows.row(v + r, channel);
    const float weight = half[static_cast<size_t>(r)];
    for (int u = 0; u < width; ++u) middle[u] += weight * (above[u] + below[u]);
  }
  std::fill_n(padded.data(), radius, middle[0]);
  std::fill_n(middle + width, radius, middle[width - 1]);
  for (int u = 0; u < width; ++u) out[u] = half[0] * middle[u];
  for (int r = 1; r <= radius; ++r) {
    const float weight = half[static_cast<size_t>(r)];
    for (int u = 0; u < width; ++u) out[u] += weight * (middle[u - r] + middle[u + r]);
  }
}

/// The light that a white deck facing the sun gives: full scale at a gain of 1.
float full_scale_of(const Light& light) {
  return std::max(1e-6F, (light.sun + light.sky).maxCoeff());
}

void expose(const float* light, const float* noise, const NoiseModel& model, float gain,
            const ResponseTable& response, int channel, int width, cv::Vec3b* levels) {
  for (int u = 0; u < width; ++u) {
    const float clean = gain * light[u],
                noisy = clean + std::sqrt(model.read + model.shot * clean) * noise[u];
    levels[u][channel] = response.level(std::min(std::max(noisy, 0.0F), 1.0F));
  }
}

}  // namespace

double level_of_light(double light, const Response& response) {
  switch (response.curve) {
    case Response::Curve::linear:
      return light;
    case Response::Curve::srgb:  // IEC 61966-2-1
      return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
    case Response::Curve::gamma:
      return std::pow(light, 1 / response.gamma);
  }
  return light;
}

NoiseTile::NoiseTile() {
  Dice dice(1, "sensor noise");
  values_.reserve(noise_values + longest_run);
  for (int i = 0; i < noise_values; ++i) values_.push_back(static_cast<float>(dice.normal()));
  for (int i = 0; i < longest_run; ++i) values_.push_back(values_[static_cast<size_t>(i)]);
}

const float* NoiseTile::run(std::uint64_t frame_seed, int row, int channel) const {
  std::uint64_t hash = frame_seed * 0x9e3779b97f4a7c15ULL + static_cast<std::uint64_t>(3 * row + channel);
  hash = (hash ^ (hash >> 31)) * 0xbf58476d1ce4e5b9ULL;
  return values_.data() + ((hash ^ (hash >> 27)) & (noise_values - 1));
}

ResponseTable::ResponseTable(const Response& response) : response_(response) {
  for (int i = 0; i <= steps; ++i)
    levels_.push_back(static_cast<std::uint8_t>(
        std::lround(255 * level_of_light(static_cast<double>(i) / steps, response))));
}

Veil::Veil(const Scene& scene, const View& view, const Picture& picture)
    : glare_(scene.surroundings.glare), width_(picture.width) {
  const auto width = static_cast<float>(picture.width), height = static_cast<float>(picture.height);
  // the sun stands beside or behind the image: stray light comes in from its side
  const Vector3f to_sun = (view.camera_from_ned * scene.light.to_sun_ned).cast<float>();
  const Eigen::Vector2f side = to_sun.head<2>() / std::max(1e-3F, to_sun.head<2>().norm());
  reach_px_ = 0.6F * width;
  sun_u_ = width / 2 + side.x() * reach_px_;
  sun_v_ = height / 2 + side.y() * reach_px_;
  glare_colour_ = (scene.light.sun + scene.light.sky) / full_scale_of(scene.light);
  if (scene.surroundings.spray <= 0) return;
  Dice dice(scene.surroundings.surface.texture, "spray");  // droplets stay where they are on the lens
  const float area = scene.surroundings.spray * width * height;
  for (float covered = 0; covered < area;) {
    const float radius = width / 640 * static_cast<float>(4 + 14 * std::pow(dice.uniform(0, 1), 3));
    const auto u = static_cast<float>(dice.uniform(0, static_cast<double>(width)));
    const auto v = static_cast<float>(dice.uniform(0, static_cast<double>(height)));
    covered += std::numbers::pi_v<float> * radius * radius;
    Vector3f sum = Vector3f::Zero();
    int count = 0;
    for (int j = -2; j <= 2; ++j)  // a droplet shows the mean of what is around it
      for (int i = -2; i <= 2; ++i) {
        const int x = std::clamp(static_cast<int>(u + static_cast<float>(i) * radius), 0, picture.width - 1);
        const int y = std::clamp(static_cast<int>(v + static_cast<float>(j) * radius), 0, picture.height - 1);
        const auto at = static_cast<size_t>(y) * static_cast<size_t>(picture.width) + static_cast<size_t>(x);
        sum += Vector3f(picture.red[at], picture.green[at], picture.blue[at]);
        ++count;
      }
    droplets_.push_back({u, v, radius, sum / static_cast<float>(count)});
  }
}

void Veil::add(int v, const RowOut& row, float full_scale) const {
  for (const Droplet& drop : droplets_) {
    const float dv = static_cast<float>(v) - drop.v;
    if (std::abs(dv) >= drop.radius) continue;
    const int first = std::max(0, static_cast<int>(drop.u - drop.radius));
    const int last = std::min(width_ - 1, static_cast<int>(drop.u + drop.radius));
    for (int u = first; u <= last; ++u) {
      const float du = static_cast<float>(u) - drop.u;
      const float from_edge = 1 - (du * du + dv * dv) / (drop.radius * drop.radius);
      if (from_edge <= 0) continue;
      const float share = 0.8F * std::min(1.0F, 1.6F * from_edge);
      const float lift = 1 - 0.25F * dv / drop.radius;  // it turns the world upside down: brighter above
      row.red[u] += share * (drop.light[0] * lift - row.red[u]);
      row.green[u] += share * (drop.light[1] * lift - row.green[u]);
      row.blue[u] += share * (drop.light[2] * lift - row.blue[u]);
    }
  }
  if (glare_ <= 0) return;
  const float dv = (static_cast<float>(v) - sun_v_) / reach_px_, per_px = 1 / reach_px_;
  for (int u = 0; u < width_; ++u) {
    const float du = (static_cast<float>(u) - sun_u_) * per_px;
    const float veil = full_scale * glare_ / (1 + du * du + dv * dv);
    row.red[u] += veil * glare_colour_[0];
    row.green[u] += veil * glare_colour_[1];
    row.blue[u] += veil * glare_colour_[2];
  }
}

void develop_rows(const Darkroom& room, int first, int last, DevelopScratch& scratch, cv::Mat& bgr) {
  const Eye& eye = room.scene.eye;
  const auto half = half_kernel(eye.blur_sigma_px);
  const NoiseModel model = noise_model(eye.noise_levels, eye.lens.response);
  const float full_scale = full_scale_of(room.scene.light), gain = eye.gain / full_scale;
  const int width = room.picture.width;
  ShutterRows rows(room, first, last, static_cast<int>(half.size()) - 1, scratch.rows);
  std::vector<float>& light = scratch.light;
  light.resize(3 * static_cast<size_t>(width));
  const RowOut out{light.data(), light.data() + width, light.data() + 2 * width};
  for (int v = first; v < last; ++v) {
    for (int channel = 0; channel < 3; ++channel)
      blur_through_lens(rows, v, channel, half, width, scratch.padded, light.data() + channel * width);
    room.veil.add(v, out, full_scale);
    auto* levels = bgr.ptr<cv::Vec3b>(v);
    for (int channel = 0; channel < 3; ++channel)
      expose(light.data() + channel * width, room.noise.run(eye.noise_seed, v, channel), model, gain,
             room.response, 2 - channel, width, levels);
  }
}

}  // namespace stevedore::world
