// What a process says of itself in HEALTH.
#pragma once

#include <cstdint>
#include <optional>
#include <stevedore/health_t.hpp>
#include <string>

namespace stevedore {

/// The name that a camera itself has among its process' inputs in HEALTH.
inline constexpr const char* source_channel = "camera";

struct Condition {
  int8_t state = health_t::STATE_OK;  ///< health_t::STATE_*
  std::string message;                ///< what is wrong, and what is done about it
  /// An input that does not come over the bus, counted beside those that do: the camera itself.
  std::optional<input_health_t> source = std::nullopt;
};

}  // namespace stevedore
