// What a process says of itself in HEALTH.
#pragma once

#include <cstdint>
#include <stevedore/health_t.hpp>
#include <string>

namespace stevedore {

struct Condition {
  int8_t state = health_t::STATE_OK;  ///< health_t::STATE_*
  std::string message;                ///< what is wrong, and what is done about it
};

}  // namespace stevedore
