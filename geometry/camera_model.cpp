#include "geometry/camera_model.hpp"

#include <cmath>
#include <cstddef>

namespace stevedore {
namespace {

/// IEC 61966-2-1.
double light_from_srgb(double level) {
  return level <= 0.04045 ? level / 12.92 : std::pow((level + 0.055) / 1.055, 2.4);
}

double light_from_level(double level, const Response& response) {
  switch (response.curve) {
    case Response::Curve::linear:
      return level;
    case Response::Curve::srgb:
      return light_from_srgb(level);
    case Response::Curve::gamma:
      return std::pow(level, response.gamma);
  }
  return level;
}

}  // namespace

std::array<float, 256> linear_light(const Response& response) {
  std::array<float, 256> light{};
  for (std::size_t level = 0; level < light.size(); ++level)
    light[level] = static_cast<float>(light_from_level(static_cast<double>(level) / 255, response));
  return light;
}

}  // namespace stevedore
