#include "lcmtypes/validate.hpp"

#include <cmath>
#include <cstddef>

namespace stevedore {
namespace {

/// Collects the first thing that is wrong.
class Check {
 public:
  explicit Check(const header_t& header) {
    require(header.utime >= 0, "header.utime", "is negative");
    require(header.frame_seq >= -1, "header.frame_seq", "is below -1");
    require(header.seq >= 0, "header.seq", "is negative");
  }

  Check& require(bool good, const char* field, const char* why) {
    if (!good && !fault_) fault_ = std::string(field) + " " + why;
    return *this;
  }
  Check& finite(const char* field, double value) {
    return require(std::isfinite(value), field, "is not a finite number");
  }
  template <std::size_t N>
  Check& finite(const char* field, const double (&values)[N]) {
    for (const double value : values) finite(field, value);
    return *this;
  }
  Check& range(const char* field, double value, double lowest, double highest) {
    return require(value >= lowest && value <= highest, field, "is out of range");  // false for NaN
  }
  template <std::size_t N>
  Check& within(const char* field, const double (&values)[N], double largest) {
    for (const double value : values) range(field, value, -largest, largest);
    return *this;
  }
  template <std::size_t Size>
  Check& unit(const char* field, const double (&v)[Size]) {
    double squares = 0;
    for (const double x : v) squares += x * x;
    return require(std::abs(squares - 1) < 1e-3, field, "is not of length one");  // false for NaN
  }
  template <std::size_t Squared>
  Check& covariance(const char* field, const double (&c)[Squared]) {
    constexpr std::size_t n = Squared == 9 ? 3 : Squared == 25 ? 5 : 6;
    static_assert(n * n == Squared);
    finite(field, c);
    for (std::size_t i = 0; i < n; ++i) require(c[i * n + i] >= 0, field, "has a negative variance");
    return *this;
  }
  template <class Array>
  Check& count(const char* field, int n, const Array& array) {
    return require(n >= 0 && static_cast<std::size_t>(n) == array.size(), field, "disagrees with the array");
  }

  [[nodiscard]] std::optional<std::string> fault() const { return fault_; }

 private:
  std::optional<std::string> fault_;
};

/// Ten times what a stage sends; association is quadratic in it.
constexpr double most_marks = 2000;

constexpr double largest_frame_px = 32767;  // int16_t

/// Far beyond what anything here does, and far below what a flipped bit of an exponent makes of a number:
/// one such value would stay in a filter for good.
constexpr double largest_position_m = 1e7, largest_velocity_mps = 1e3, largest_rate_radps = 100,
                 largest_heading_rad = 1e3;

void check_shape(Check& check, const ellipse_shape_t& e) {
  check.finite("u_px", e.u_px).finite("v_px", e.v_px).finite("a_px", e.a_px).finite("alpha_rad", e.alpha_rad);
  check.require(e.b_px > 0 && e.a_px >= e.b_px, "ellipse", "has no semi-axes a >= b > 0");
  check.covariance("covariance", e.covariance);
}

void check_ellipse(Check& check, const ellipse_t& e) {
  check_shape(check, e.outer);
  if (e.has_inner) check_shape(check, e.inner);
  check.range("error", e.error, 0, 1e9).range("coverage", e.coverage, 0, 1);
  check.range("kind", e.kind, ellipse_t::KIND_WHOLE, ellipse_t::KIND_PARTIAL);
  check.range("label", e.label, ellipse_t::LABEL_UNKNOWN, ellipse_t::LABEL_CARGO);
  check.range("occupied", e.occupied, ellipse_t::OCCUPIED_UNKNOWN, ellipse_t::OCCUPIED_YES);
}

void check_status(Check& check, const char* field, int8_t status) {
  check.range(field, status, track_t::STATUS_SEARCHING, track_t::STATUS_LOST);
}

}  // namespace

std::optional<std::string> fault_of(const frame_t& m) {
  Check check(m.header);
  check.require(m.width_px > 0 && m.height_px > 0, "frame size", "is not positive");
  check.range("format", m.format, frame_t::FORMAT_GRAY8, frame_t::FORMAT_BGR8);
  check.range("encoding", m.encoding, frame_t::ENCODING_RING, frame_t::ENCODING_PNG);
  check.count("size", m.size, m.data);
  if (m.encoding == frame_t::ENCODING_RING) {
    check.require(m.size == 0, "size", "is not 0 for a reference");
    check.require(!m.ring_name.empty(), "ring_name", "is empty").range("ring_slot", m.ring_slot, 0, 1e6);
  }
  if (m.encoding == frame_t::ENCODING_RAW) {
    const int channels = m.format == frame_t::FORMAT_BGR8 ? 3 : 1;
    check.require(m.size == int64_t{m.width_px} * m.height_px * channels, "size",
                  "is not width x height x channels");
  }
  return check.fault();
}

std::optional<std::string> fault_of(const ellipses_t& m) {
  Check check(m.header);
  check.count("count", m.count, m.ellipses).range("count", m.count, 0, most_marks);
  check.require(m.width_px > 0 && m.height_px > 0, "frame size", "is not positive");
  check.range("search", m.search, ellipses_t::SEARCH_FULL, ellipses_t::SEARCH_REGION);
  for (const auto& e : m.ellipses) check_ellipse(check, e);
  return check.fault();
}

std::optional<std::string> fault_of(const tracks_t& m) {
  Check check(m.header);
  check.count("count", m.count, m.tracks).range("count", m.count, 0, most_marks);
  check.require(m.width_px > 0 && m.height_px > 0, "frame size", "is not positive");
  check_status(check, "target_status", m.target_status);
  for (const auto& t : m.tracks) {
    check.require(t.id >= 0, "id", "is negative").range("ellipse_index", t.ellipse_index, -1, 32767);
    check_ellipse(check, t.ellipse);
    check_status(check, "status", t.status);
    check.finite("velocity_u_pxps", t.velocity_u_pxps).finite("velocity_v_pxps", t.velocity_v_pxps);
    check.range("unseen_s", t.unseen_s, 0, 1e9);
  }
  if (m.has_window) {
    check.finite("window_u_px", m.window_u_px).finite("window_v_px", m.window_v_px);
    check.range("window_a_px", m.window_a_px, 0, largest_frame_px)
        .range("window_b_px", m.window_b_px, 0, largest_frame_px);
    check.finite("window_alpha_rad", m.window_alpha_rad);
  }
  return check.fault();
}

std::optional<std::string> fault_of(const poses_t& m) {
  Check check(m.header);
  check.count("count", m.count, m.poses).range("count", m.count, 0, most_marks);
  check_status(check, "target_status", m.target_status);
  if (m.has_gravity) check.unit("gravity_camera", m.gravity_camera);
  for (const auto& p : m.poses) {
    check.range("ellipse_index", p.ellipse_index, -1, 32767);
    check_status(check, "status", p.status);
    check.finite("u_px", p.u_px).finite("v_px", p.v_px).range("coverage", p.coverage, 0, 1);
    check.require(p.b_px > 0 && p.a_px >= p.b_px, "ellipse", "has no semi-axes a >= b > 0")
        .finite("a_px", p.a_px);
    check.range("kind", p.kind, ellipse_t::KIND_WHOLE, ellipse_t::KIND_PARTIAL);
    check.range("label", p.label, ellipse_t::LABEL_UNKNOWN, ellipse_t::LABEL_CARGO);
    check.range("occupied", p.occupied, ellipse_t::OCCUPIED_UNKNOWN, ellipse_t::OCCUPIED_YES);
    check.range("chosen_by", p.chosen_by, pose_t::CHOSEN_BY_NONE, pose_t::CHOSEN_BY_OPTICAL_AXIS);
    check.range("radius_m", p.radius_m, 0, 1e3);
    check.range("solution_count", p.solution_count, 0, 2)
        .count("solution_count", p.solution_count, p.solutions);
    for (const auto& s : p.solutions) {
      check.finite("center_camera_m", s.center_camera_m).unit("normal_camera", s.normal_camera);
      check.covariance("covariance_m2", s.covariance_m2).range("probability", s.probability, 0, 1);
    }
    check.finite("center_level_m", p.center_level_m);
  }
  return check.fault();
}

std::optional<std::string> fault_of(const platform_estimate_t& m) {
  Check check(m.header);
  check.count("slot_count", m.slot_count, m.slots)
      .count("prediction_count", m.prediction_count, m.predictions);
  for (const auto& s : m.slots) {
    check.finite("center_ned_m", s.center_ned_m).covariance("covariance_m2", s.covariance_m2);
    check.range("confidence", s.confidence, 0, 1)
        .range("state", s.state, slot_t::STATE_UNKNOWN, slot_t::STATE_MISPLACED);
  }
  for (const auto& p : m.predictions) {
    check.range("ahead_s", p.ahead_s, 0, 60).finite("center_ned_m", p.center_ned_m);
    check.finite("velocity_ned_mps", p.velocity_ned_mps).unit("normal_ned", p.normal_ned);
    check.covariance("covariance", p.covariance);
  }
  check.finite("center_ned_m", m.center_ned_m).finite("velocity_ned_mps", m.velocity_ned_mps);
  check.finite("heading_rad", m.heading_rad).range("heading_variance_rad2", m.heading_variance_rad2, 0, 1e9);
  check.finite("turn_rate_radps", m.turn_rate_radps);
  check.finite("heave_m", m.heave_m).finite("roll_rad", m.roll_rad).finite("pitch_rad", m.pitch_rad);
  check.covariance("covariance", m.covariance);
  return check.fault();
}

std::optional<std::string> fault_of(const mission_t& m) {
  Check check(m.header);
  check.count("candidate_count", m.candidate_count, m.candidates);
  check.count("emergency_count", m.emergency_count, m.emergencies);
  for (const auto& c : m.candidates) {
    check.finite("cost", c.cost).range("label", c.label, ellipse_t::LABEL_UNKNOWN, ellipse_t::LABEL_CARGO);
  }
  for (const auto& e : m.emergencies) {
    check.range("kind", e.kind, emergency_t::KIND_ALL_OUT_OF_VIEW, emergency_t::KIND_IDENTITY_UNCERTAIN);
    check.range("age_s", e.age_s, 0, 1e9).range("confidence", e.confidence, 0, 1);
    check.range("advised_action", e.advised_action, mission_t::ACTION_NONE, mission_t::ACTION_LAND);
  }
  check.range("phase", m.phase, mission_t::PHASE_IDLE, mission_t::PHASE_COMPLETE);
  check.range("action", m.action, mission_t::ACTION_NONE, mission_t::ACTION_LAND);
  check_status(check, "target_status", m.target_status);
  check.finite("target_level_m", m.target_level_m)
      .covariance("target_level_covariance_m2", m.target_level_covariance_m2);
  check.finite("target_ned_m", m.target_ned_m)
      .covariance("target_ned_covariance_m2", m.target_ned_covariance_m2);
  check.finite("target_velocity_ned_mps", m.target_velocity_ned_mps)
      .range("target_age_s", m.target_age_s, -1, 1e9);
  check.within("setpoint_ned_m", m.setpoint_ned_m, largest_position_m)
      .within("setpoint_velocity_ned_mps", m.setpoint_velocity_ned_mps, largest_velocity_mps)
      .range("setpoint_heading_rad", m.setpoint_heading_rad, -largest_heading_rad, largest_heading_rad);
  return check.fault();
}

std::optional<std::string> fault_of(const mission_journal_t& m) {
  Check check(m.header);
  check.count("delivery_count", m.delivery_count, m.deliveries);
  check.count("failure_count", m.failure_count, m.failures).count("taken_count", m.taken_count, m.taken);
  check.range("attempts", m.attempts, 0, 32767).range("written_off", m.written_off, 0, 32767);
  check.range("hook_lessons", m.hook_lessons, 0, 32767).finite("hook_off_m", m.hook_off_m);
  for (const auto& d : m.deliveries) check.range("off_m", d.off_m, -1, 1e3);
  for (const auto& f : m.failures) check.range("times", f.times, 0, 32767);
  check.range("phase", m.phase, mission_t::PHASE_IDLE, mission_t::PHASE_COMPLETE);
  check.finite("home_ned_m", m.home_ned_m);
  return check.fault();
}

std::optional<std::string> fault_of(const track_command_t& m) {
  Check check(m.header);
  check.range("action", m.action, track_command_t::ACTION_RELEASE, track_command_t::ACTION_FIRST_CIRCLE);
  check.finite("u_px", m.u_px).finite("v_px", m.v_px);
  return check.fault();
}

std::optional<std::string> fault_of(const mission_command_t& m) {
  Check check(m.header);
  check.range("command", m.command, mission_command_t::COMMAND_START, mission_command_t::COMMAND_CHOOSE);
  return check.fault();
}

std::optional<std::string> fault_of(const vehicle_state_t& m) {
  Check check(m.header);
  check.within("position_ned_m", m.position_ned_m, largest_position_m)
      .within("velocity_ned_mps", m.velocity_ned_mps, largest_velocity_mps);
  check.unit("ned_from_body", m.ned_from_body)
      .within("angular_rate_body_radps", m.angular_rate_body_radps, largest_rate_radps);
  for (int i = 0; i < 3; ++i) {
    check.range("position_variance_m2", m.position_variance_m2[i], 0, 1e12);
    check.range("velocity_variance_m2ps2", m.velocity_variance_m2ps2[i], 0, 1e12);
    check.range("attitude_variance_rad2", m.attitude_variance_rad2[i], 0, 1e3);
  }
  return check.fault();
}

std::optional<std::string> fault_of(const autopilot_status_t& m) {
  Check check(m.header);
  check.range("mode", m.mode, autopilot_status_t::MODE_MANUAL, autopilot_status_t::MODE_LAND);
  check.range("battery_share", m.battery_share, 0, 1).range("battery_v", m.battery_v, 0, 1e4);
  return check.fault();
}

std::optional<std::string> fault_of(const gimbal_command_t& m) {
  return Check(m.header).range("roll_rad", m.roll_rad, -4, 4).range("pitch_rad", m.pitch_rad, -4, 4).fault();
}

std::optional<std::string> fault_of(const gimbal_state_t& m) {
  Check check(m.header);
  check.range("roll_rad", m.roll_rad, -4, 4).range("pitch_rad", m.pitch_rad, -4, 4);
  check.range("off_level_rad", m.off_level_rad, -1, 4);
  check.range("status", m.status, gimbal_state_t::STATUS_OK, gimbal_state_t::STATUS_LATE);
  return check.fault();
}

std::optional<std::string> fault_of(const altimeter_t& m) {
  return Check(m.header)
      .range("range_m", m.range_m, 0, 1e4)
      .range("variance_m2", m.variance_m2, 0, 1e6)
      .fault();
}

std::optional<std::string> fault_of(const hook_state_t& m) {
  return Check(m.header).range("load_n", m.load_n, -1e5, 1e5).fault();
}

std::optional<std::string> fault_of(const platform_state_t& m) {
  Check check(m.header);
  check.within("position_ned_m", m.position_ned_m, largest_position_m)
      .within("velocity_ned_mps", m.velocity_ned_mps, largest_velocity_mps);
  check.range("heading_rad", m.heading_rad, -largest_heading_rad, largest_heading_rad);
  for (const double variance : m.position_variance_m2) check.range("position_variance_m2", variance, 0, 1e12);
  return check.fault();
}

std::optional<std::string> fault_of(const health_t& m) {
  Check check(m.header);
  check.count("input_count", m.input_count, m.inputs).count("output_count", m.output_count, m.outputs);
  check.require(!m.process.empty(), "process", "is empty");
  check.range("state", m.state, health_t::STATE_STARTING, health_t::STATE_FINISHED);
  for (const auto& i : m.inputs) check.finite("age_p50_ms", i.age_p50_ms).finite("age_p99_ms", i.age_p99_ms);
  return check.fault();
}

std::optional<std::string> fault_of(const timeout_t& m) {
  return Check(m.header)
      .require(!m.channel.empty(), "channel", "is empty")
      .range("silent_s", m.silent_s, 0, 1e9)
      .fault();
}

std::optional<std::string> fault_of(const truth_t& m) {
  Check check(m.header);
  check.count("circle_count", m.circle_count, m.circles).count("cargo_count", m.cargo_count, m.cargoes);
  check.finite("position_ned_m", m.position_ned_m).unit("ned_from_body", m.ned_from_body);
  check.finite("camera_ned_m", m.camera_ned_m).unit("ned_from_camera", m.ned_from_camera);
  return check.fault();
}

bool size_is_there(const void* data, int size, const frame_t*) {
  constexpr int hash_bytes = 8, count_bytes = 4;
  header_t header{};
  try {
    const int header_bytes = header._decodeNoHash(data, hash_bytes, size - hash_bytes);
    if (header_bytes < 0 || hash_bytes + header_bytes + count_bytes > size) return false;
    const auto* count =
        static_cast<const uint8_t*>(data) + hash_bytes + header_bytes;  // big-endian, after the header
    const int64_t wanted =
        int64_t{count[0]} << 24 | int64_t{count[1]} << 16 | int64_t{count[2]} << 8 | int64_t{count[3]};
    return wanted <= size;
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace stevedore
