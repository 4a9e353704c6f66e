#include "tools/deliveries.hpp"

#include <algorithm>
#include <cmath>

namespace stevedore {

std::vector<BroughtCargo> brought_cargoes(const truth_t& start, const truth_t& now) {
  std::vector<BroughtCargo> brought;
  for (const truth_cargo_t& cargo : now.cargoes) {
    const auto before = std::find_if(start.cargoes.begin(), start.cargoes.end(),
                                     [&](const truth_cargo_t& each) { return each.index == cargo.index; });
    const bool moved = before != start.cargoes.end() && before->platform != cargo.platform;
    if (!moved || cargo.platform < 0 || cargo.slot < 0 || cargo.tipped || cargo.on_hook) continue;
    for (const truth_circle_t& circle : now.circles) {
      if (circle.platform != cargo.platform || circle.slot != cargo.slot) continue;
      brought.push_back({cargo.index, std::hypot(cargo.center_ned_m[0] - circle.center_ned_m[0],
                                                 cargo.center_ned_m[1] - circle.center_ned_m[1])});
    }
  }
  return brought;
}

std::vector<double> drop_errors_m(const truth_t& start, const truth_t& now) {
  std::vector<double> errors_m;
  for (const BroughtCargo& each : brought_cargoes(start, now)) errors_m.push_back(each.off_m);
  return errors_m;
}

}  // namespace stevedore
