// The two clocks: CLOCK_MONOTONIC for everything, UTC only to say by how much it differs, and in logs.
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

/// UTC as it was at the start, carried on by CLOCK_MONOTONIC: what sets the wall clock does not tear it.
class SteadyUtc {
 public:
  [[nodiscard]] int64_t now() const { return offset_us_ + monotonic_utime(); }

 private:
  const int64_t offset_us_ = utc_offset_us();
};

}  // namespace stevedore
