// The two clocks: CLOCK_MONOTONIC for everything, UTC only to say by how much it differs.
#pragma once

#include <cstdint>
#include <ctime>

namespace stevedore {

inline int64_t clock_utime(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return int64_t{now.tv_sec} * 1'000'000 + now.tv_nsec / 1000;
}

inline int64_t monotonic_utime() {
  return clock_utime(CLOCK_MONOTONIC);
}
inline int64_t utc_offset_us() {
  return clock_utime(CLOCK_REALTIME) - monotonic_utime();
}

}  // namespace stevedore
