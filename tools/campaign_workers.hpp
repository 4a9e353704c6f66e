// Missions flown by processes of their own, several at a time: one that crashes is one mission that failed.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace stevedore {

struct WorkerEnd {
  std::int64_t seed = 0;
  std::string out;    ///< its standard output
  std::string fault;  ///< why it did not end well; empty: it did
  bool is_usage_error = false;
  double wall_s = 0;
};

struct WorkerOrders {
  std::vector<std::int64_t> seeds;  ///< a worker each, in this order
  int jobs = 1;                     ///< as many at a time
  /// This program's arguments, without its name.
  std::function<std::vector<std::string>(std::int64_t seed)> arguments;
  std::function<void(const WorkerEnd&)> ended;
  std::function<bool()> stops;  ///< workers are then ended, and not told of
};

/// Until all have ended. They end with this process, however that ends. Throws std::runtime_error where no
/// process can be started.
void run_workers(const WorkerOrders& orders);

}  // namespace stevedore
