#include "lcmtypes/channels.hpp"

namespace stevedore {

std::vector<ChannelInfo> channel_table() {
  std::vector<ChannelInfo> table;
  const auto add = [&table]<class M>(const Channel<M>& c) {
    table.push_back({c.name, M::getTypeName(), c.publisher, c.rate_hz, c.max_age_s, c.logged});
  };
  std::apply([&add](const auto&... channel) { (add(channel), ...); }, channels::all);
  return table;
}

}  // namespace stevedore
