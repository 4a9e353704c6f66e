// Two answers of a detector that must not differ in a single bit.
#pragma once

#include <catch2/catch.hpp>
#include <cstring>
#include <vector>

#include "detector_proc/detector.hpp"

namespace stevedore {

inline void check_same_to_the_bit(const std::vector<Detection>& first, const std::vector<Detection>& second) {
  REQUIRE(first.size() == second.size());
  for (std::size_t k = 0; k < first.size(); ++k) {
    CHECK(std::memcmp(&first[k].outer.ellipse, &second[k].outer.ellipse, sizeof(Ellipse)) == 0);
    CHECK(first[k].outer.covariance == second[k].outer.covariance);
    CHECK(first[k].error == second[k].error);
    CHECK(first[k].coverage == second[k].coverage);
    CHECK(first[k].label == second[k].label);
    CHECK(first[k].occupied == second[k].occupied);
  }
}

}  // namespace stevedore
