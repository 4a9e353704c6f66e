// What `doctor` looks at: whether this machine can run the set, and what to do where it can't.
#pragma once

#include <string>
#include <vector>

namespace stevedore {

/// fix: the set does not run. limited: it runs, something beside it does not.
enum class Verdict { ok, limited, fix };

struct Finding {
  std::string what;  ///< e.g. "loopback"
  Verdict verdict = Verdict::ok;
  std::string text;  ///< what was found; where it is not ok, what to do
};

/// Every check, in the order in which a fault of one explains the next.
std::vector<Finding> all_findings();

/// The interface that multicast of the default LCM address leaves by, from the text of /proc/net/route;
/// empty: there is no route.
std::string multicast_interface(const std::string& route_table);

/// Whether the kernel's receive buffers hold what inline frames need.
Finding judge_receive_buffer(long rmem_max_bytes);

}  // namespace stevedore
