#include "tests/support/memory_bus.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "runtime/frame_codec.hpp"
#include "runtime/kernel.hpp"
#include "runtime/lcm_bus.hpp"

using namespace stevedore;

namespace {

hook_state_t hook(double load_n = 15) {
  hook_state_t message{};
  message.header.utime = 900;
  message.header.frame_seq = -1;
  message.load_n = load_n;
  return message;
}

template <class M>
M decoded(const std::vector<uint8_t>& bytes) {
  M message{};
  REQUIRE(message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) == static_cast<int>(bytes.size()));
  return message;
}

}  // namespace

TEST_CASE("what is published is numbered and stamped, and arrives") {
  MemoryBus sender(1), receiver(2);
  std::vector<double> loads;
  receiver.subscribe<hook_state_t>(channels::hook_state,
                                   [&](const hook_state_t& m) { loads.push_back(m.load_n); });
  CHECK(receiver.listened == std::vector<std::string>{"HOOK_STATE"});
  for (int i = 0; i < 3; ++i) sender.publish(channels::hook_state, hook(i));
  for (const auto& [channel, bytes] : sender.sent) receiver.deliver(channel, bytes);
  CHECK(loads == std::vector<double>{0, 1, 2});
  const auto last = decoded<hook_state_t>(sender.sent[2].second);
  CHECK(last.header.seq == 2);
  CHECK(last.header.trace.run_id == 1);
  CHECK(last.header.trace.publish_utime == 1000);
  CHECK(last.header.trace.cause.empty());
  CHECK(receiver.take_ages_us("HOOK_STATE") == std::vector<int64_t>{100, 100, 100});
}

TEST_CASE("gaps are counted, a restarted publisher is none") {
  MemoryBus sender(1), restarted(3), receiver(2);
  receiver.subscribe<hook_state_t>(channels::hook_state, [](const hook_state_t&) {});
  for (int i = 0; i < 6; ++i) sender.publish(channels::hook_state, hook());
  restarted.publish(channels::hook_state, hook());
  for (const int i : {0, 1, 4, 5}) receiver.deliver("HOOK_STATE", sender.sent[static_cast<size_t>(i)].second);
  CHECK(receiver.counters("HOOK_STATE").lost_gap == 2);
  receiver.deliver("HOOK_STATE", restarted.sent[0].second);
  CHECK(receiver.counters("HOOK_STATE").lost_gap == 2);
  CHECK(receiver.counters("HOOK_STATE").handled == 5);
}

TEST_CASE("a corrupt message is counted and dropped, never handed out") {
  MemoryBus sender, receiver;
  int handled = 0;
  receiver.subscribe<hook_state_t>(channels::hook_state, [&](const hook_state_t&) { ++handled; });
  receiver.subscribe<ellipses_t>(channels::ellipses, [&](const ellipses_t&) { ++handled; });
  sender.publish(channels::hook_state, hook());
  const auto good = sender.sent[0].second;

  receiver.deliver("HOOK_STATE", {});
  receiver.deliver("HOOK_STATE", {1, 2, 3});
  auto bytes = good;
  bytes[0] = static_cast<uint8_t>(bytes[0] ^ 1);  // another type
  receiver.deliver("HOOK_STATE", bytes);
  for (size_t length = 0; length < good.size(); ++length) {
    receiver.deliver("HOOK_STATE", {good.begin(), good.begin() + static_cast<long>(length)});
  }
  bytes = std::vector<uint8_t>(good.size() + 1);  // too long
  std::copy(good.begin(), good.end(), bytes.begin());
  receiver.deliver("HOOK_STATE", bytes);
  MemoryBus spoiler;
  spoiler.publish(channels::hook_state, hook(std::numeric_limits<double>::quiet_NaN()));
  receiver.deliver("HOOK_STATE", spoiler.sent[0].second);
  CHECK(handled == 0);
  CHECK(receiver.counters("HOOK_STATE").lost_malformed == static_cast<int64_t>(5 + good.size()));

  ellipses_t ellipses{};
  ellipses.width_px = ellipses.height_px = 10;
  ellipses.search = ellipses_t::SEARCH_FULL;
  spoiler.publish(channels::ellipses, ellipses);
  const auto empty = spoiler.sent.back().second;
  const size_t count_at = empty.size() - 2 - 2 - 2 - 8 - 1 - 4 -
                          1;  // count, then width, height, tracks_frame_seq, search, method
  for (const uint8_t high : {uint8_t{0x7f}, uint8_t{0xff}}) {  // a huge and a negative count
    auto changed = empty;
    changed[count_at] = high;
    receiver.deliver("ELLIPSES", changed);
  }
  CHECK(receiver.counters("ELLIPSES").lost_malformed == 2);
  receiver.deliver("ELLIPSES", empty);
  CHECK(handled == 1);
}

TEST_CASE("finite numbers that nothing here can have are refused") {
  vehicle_state_t state{};
  state.ned_from_body[0] = 1;
  state.position_ned_m[0] = 1e6;  // an origin far away
  state.velocity_ned_mps[1] = -300;
  state.angular_rate_body_radps[2] = 30;
  CHECK_FALSE(fault_of(state));
  const auto refused = [](auto message, double& (*field)(decltype(message)&), double largest) {
    for (const double sign : {-1.0, 1.0}) {
      field(message) = sign * largest;
      CHECK_FALSE(fault_of(message));
      for (const double absurd : {2 * largest, 1e305, std::numeric_limits<double>::quiet_NaN()}) {
        field(message) = sign * absurd;
        CHECK(fault_of(message));
      }
    }
  };
  using State = vehicle_state_t;
  refused(
      state, +[](State& m) -> double& { return m.position_ned_m[2]; }, 1e7);
  refused(
      state, +[](State& m) -> double& { return m.velocity_ned_mps[0]; }, 1e3);
  refused(
      state, +[](State& m) -> double& { return m.angular_rate_body_radps[1]; }, 100);
  using Platform = platform_state_t;
  refused(
      Platform{}, +[](Platform& m) -> double& { return m.position_ned_m[0]; }, 1e7);
  refused(
      Platform{}, +[](Platform& m) -> double& { return m.velocity_ned_mps[1]; }, 1e3);
  refused(
      Platform{}, +[](Platform& m) -> double& { return m.heading_rad; }, 1e3);
  mission_t mission{};
  mission.phase = mission_t::PHASE_IDLE;
  mission.target_status = track_t::STATUS_SEARCHING;
  refused(
      mission, +[](mission_t& m) -> double& { return m.setpoint_ned_m[1]; }, 1e7);
  refused(
      mission, +[](mission_t& m) -> double& { return m.setpoint_velocity_ned_mps[2]; }, 1e3);
  refused(
      mission, +[](mission_t& m) -> double& { return m.setpoint_heading_rad; }, 1e3);
}

TEST_CASE("a refused message whose header can be read is lost once, as malformed") {
  MemoryBus receiver;
  receiver.subscribe<hook_state_t>(channels::hook_state, [](const hook_state_t&) {});
  const auto send = [&receiver](int64_t run_id, int64_t seq, double load_n, size_t cut = 0) {
    hook_state_t message = hook(load_n);
    message.header.seq = seq;
    message.header.trace.run_id = run_id;
    auto bytes = encode(message);
    bytes.resize(bytes.size() - cut);
    receiver.deliver("HOOK_STATE", bytes);
  };
  const auto lost = [&receiver] {
    const InputCounters& counters = receiver.counters("HOOK_STATE");
    return std::pair(counters.lost_gap, counters.lost_malformed);
  };
  constexpr double bad = std::numeric_limits<double>::quiet_NaN();
  using Lost = std::pair<int64_t, int64_t>;
  send(3, 0, 15);
  send(3, 1, bad);
  send(3, 2, 15, 1);  // its last byte is missing
  send(3, 3, 15);
  CHECK(lost() == Lost{0, 2});
  send(3, 6, bad);  // 4 and 5 never came
  send(3, 7, 15);
  CHECK(lost() == Lost{2, 3});
  send(3, int64_t{1} << 40, bad);  // no number to believe
  send(4, 500, bad);               // nor one of a publisher never heard
  send(3, 8, 15);
  send(4, 0, 15);
  CHECK(lost() == Lost{2, 5});
  receiver.deliver("HOOK_STATE", {1, 2, 3});  // without a header: also a gap when 9 is missing
  send(3, 10, 15);
  CHECK(lost() == Lost{3, 6});
}

TEST_CASE("newest: what is superseded is skipped, not lost") {
  MemoryBus sender, receiver;
  std::vector<double> loads;
  receiver.subscribe<hook_state_t>(
      channels::hook_state, [&](const hook_state_t& m) { loads.push_back(m.load_n); }, Delivery::newest);
  for (int i = 0; i < 5; ++i) sender.publish(channels::hook_state, hook(i));
  for (const auto& [channel, bytes] : sender.sent) receiver.deliver(channel, bytes);
  CHECK(loads.empty());
  receiver.deliver_newest();
  receiver.deliver_newest();
  CHECK(loads == std::vector<double>{4});
  CHECK(receiver.counters("HOOK_STATE").skipped == 4);
  CHECK(receiver.counters("HOOK_STATE").handled == 1);
  CHECK(receiver.counters("HOOK_STATE").lost_gap == 0);
}

TEST_CASE("an answer says what it answers and what had been read") {
  MemoryBus sender(11), middle(12);
  middle.subscribe<altimeter_t>(channels::altimeter, [](const altimeter_t&) {});
  middle.subscribe<hook_state_t>(channels::hook_state,
                                 [&](const hook_state_t& m) { middle.publish(channels::hook_state, m); });
  altimeter_t altimeter{};
  for (int i = 0; i < 3; ++i) sender.publish(channels::altimeter, altimeter);
  sender.publish(channels::hook_state, hook());
  middle.now = 5000;
  for (const auto& [channel, bytes] : sender.sent) middle.deliver(channel, bytes);
  const auto answer = decoded<hook_state_t>(middle.sent[0].second);
  CHECK(answer.header.trace.cause == "HOOK_STATE");
  CHECK(answer.header.trace.receive_utime == 5000);
  REQUIRE(answer.header.trace.inputs.size() == 2);
  CHECK(answer.header.trace.inputs[0].channel == "ALTIMETER");
  CHECK(answer.header.trace.inputs[0].first_seq == 0);
  CHECK(answer.header.trace.inputs[0].seq == 2);
  CHECK(answer.header.trace.inputs[1].channel == "HOOK_STATE");
  CHECK(answer.header.trace.inputs[1].run_id == 11);
}

TEST_CASE("subscribing twice and inconsistent messages are programming errors") {
  MemoryBus bus;
  bus.subscribe<hook_state_t>(channels::hook_state, [](const hook_state_t&) {});
  CHECK_THROWS_AS(bus.subscribe<hook_state_t>(channels::hook_state, [](const hook_state_t&) {}),
                  std::logic_error);
}

TEST_CASE("a late message takes its gap back, a forged number is none") {
  MemoryBus receiver;
  receiver.subscribe<hook_state_t>(channels::hook_state, [](const hook_state_t&) {});
  const auto send = [&receiver](int64_t seq) {
    hook_state_t message = hook();
    message.header.seq = seq;
    message.header.trace.run_id = 3;
    receiver.deliver(channels::hook_state, message);
    return receiver.counters("HOOK_STATE").lost_gap;
  };
  CHECK(send(5) == 0);
  CHECK(send(7) == 1);
  CHECK(send(6) == 0);
  CHECK(send(8) == 0);
  CHECK(send(int64_t{1} << 62) == 0);
  CHECK(send(int64_t{1} << 62) == 0);
}

TEST_CASE("a frame that claims more bytes than it brings is refused before they are reserved") {
  frame_t frame{};
  frame.width_px = frame.height_px = 10;
  frame.format = frame_t::FORMAT_GRAY8;
  frame.encoding = frame_t::ENCODING_JPEG;
  frame.size = 4;
  frame.data = {1, 2, 3, 4};
  const auto good = encode(frame);
  CHECK(decode_checked<frame_t>(good.data(), static_cast<int>(good.size())));
  auto forged = good;
  const size_t size_at =
      good.size() - 4 - 8 - 4 - 8 - 5 - 2 - 4 - 4;  // data, ring fields, encodings, height and width before
  REQUIRE(forged[size_at + 3] == 4);
  forged[size_at] = 0x7f;
  CHECK_FALSE(
      size_is_there(forged.data(), static_cast<int>(forged.size()), static_cast<const frame_t*>(nullptr)));
  CHECK_FALSE(decode_checked<frame_t>(forged.data(), static_cast<int>(forged.size())));
  for (int size = 0; size < static_cast<int>(good.size()); ++size)
    CHECK_FALSE(decode_checked<frame_t>(good.data(), size));
}

TEST_CASE("a text whose length is the least number of all is refused before it is read") {
  constexpr size_t cause_length_at = 8 + 6 * 8;  // fingerprint; utime, frame_seq, seq, run_id, two stamps
  MemoryBus sender, receiver;
  receiver.subscribe<hook_state_t>(channels::hook_state, [](const hook_state_t&) {});
  sender.publish(channels::hook_state, hook());
  auto bytes = sender.sent[0].second;
  REQUIRE(bytes[cause_length_at + 3] == 1);  // no text: its closing zero alone
  bytes[cause_length_at] = 0x80;
  bytes[cause_length_at + 3] = 0;
  receiver.deliver("HOOK_STATE", bytes);
  CHECK(receiver.counters("HOOK_STATE").lost_malformed == 1);
}

TEST_CASE("the time of what is heard is the others', not this host's") {
  MemoryBus bus;
  bus.subscribe<hook_state_t>(channels::hook_state, [](const hook_state_t&) {});
  bus.now = 5'000'000;
  CHECK(bus.stream_utime() == 5'000'000);
  bus.deliver(channels::hook_state, hook());  // captured at 900
  bus.now += 250;
  CHECK(bus.stream_utime() == 1150);
}

TEST_CASE("what the bus' sockets ask the kernel for is said by its address") {
  CHECK(asked_receive_buffer(default_lcm_url) == 2'097'152);
  CHECK(asked_receive_buffer("udpm://239.255.76.67:7667?recv_buf_size=300000&ttl=0") == 300'000);
  CHECK(asked_receive_buffer("udpm://239.255.76.67:7667?ttl=0") == granted_receive_buffer(0));
}

TEST_CASE("two buses in one network have names of their own in shared memory") {
  const std::string other = "udpm://239.255.76.68:7668?ttl=0";
  const std::string name = name_in_this_network("camera", default_lcm_url);
  CHECK(name != name_in_this_network("camera", other));
  CHECK(name == name_in_this_network("camera", default_lcm_url));  // who comes back finds its own
  CHECK(name.starts_with(name_in_this_network("camera")));
  CHECK(name.size() <= 64);  // FrameRing
}
