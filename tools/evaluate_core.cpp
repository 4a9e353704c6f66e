#include "tools/evaluate_core.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "runtime/camera_file.hpp"
#include "runtime/config.hpp"
#include "sim_proc/sim_stage.hpp"
#include "sim_proc/world/told_and_true.hpp"

namespace stevedore {

namespace {

/// What of a standard deviation is not in another one, which is of the same error.
double beyond(double whole, double told) {
  return std::sqrt(std::max(0.0, whole * whole - told * told));
}

}  // namespace

Aircraft aircraft_of(const FlownConfiguration& flown) {
  Aircraft aircraft;
  if (flown.file.empty() && flown.settings.empty()) return aircraft;
  const Config config = Config::load(flown.file, flown.settings);
  const auto settings = config.section<PoseSettings>("pose");
  aircraft.laser.from_camera_body_m = {settings.altimeter_forward_m, settings.altimeter_right_m,
                                       settings.altimeter_down_m};
  const auto camera = camera_of(config);
  if (!camera) return aircraft;
  aircraft.laser.camera = camera->mount;
  if (config.section<SimSettings>("sim").easy) return aircraft;
  const world::TellingErrors drawn;
  aircraft.common = CommonError{camera->rectified, {}};
  PoseSettings& sigmas = aircraft.common->sigmas;
  sigmas.radius_sigma_percent = beyond(100 * drawn.circle_share, settings.radius_sigma_percent);
  sigmas.focal_sigma_percent = beyond(100 * drawn.focal_share, settings.focal_sigma_percent);
  sigmas.principal_point_sigma_px = beyond(drawn.principal_point_px, settings.principal_point_sigma_px);
  return aircraft;
}

Evaluation evaluate(const std::string& log, const FlownConfiguration& flown, const std::string& reference) {
  const Aircraft aircraft = aircraft_of(flown);
  Evaluation evaluation;
  evaluation.log = log;
  evaluation.reference_log = reference;
  evaluation.flight = read_flight(log);
  const FlightLog& flight = evaluation.flight;
  if (!flight.truth.empty()) {
    evaluation.poses = compare_poses(flight.poses, marks_of(flight.truth), aircraft.common);
    evaluation.platforms = compare_platforms(flight);
    evaluation.drops = find_drops(flight.truth, *evaluation.poses);
  }
  if (!reference.empty()) {
    const FlightLog other = read_flight(reference);
    evaluation.reference = compare_poses(flight.poses, marks_of(other.poses), std::nullopt);
    evaluation.reference_damage = other.damage;
  }
  evaluation.altitudes = compare_altitudes(flight, aircraft.laser);
  evaluation.to_poses_ms = spread_of(flight.to_poses_ms);
  evaluation.to_mission_ms = spread_of(flight.to_mission_ms);
  return evaluation;
}

namespace {

double percent(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? 100 * static_cast<double>(part) / static_cast<double>(whole) : 0;
}

PoseRow all_circles(const PoseComparison& poses) {
  return row_of("circles", poses.samples,
                [](const PoseSample& sample) { return sample.kind == Mark::Kind::circle; });
}

class Verdicts {
 public:
  /// count: of what the figure rests on; fewer than few are shown, but nothing is said by them.
  void add(std::int64_t count, bool is_good, std::string subject, std::string text, std::string limit) {
    constexpr std::int64_t few = 10;
    const auto says = count < few ? Verdict::Says::nothing
                      : is_good   ? Verdict::Says::good
                                  : Verdict::Says::poor;
    list.push_back({says, std::move(subject), count > 0 ? std::move(text) : "no data", std::move(limit)});
  }
  std::vector<Verdict> list;
};

/// Range errors of one kind of mark as a share of the range.
void judge_ranges(const PoseComparison& poses, Mark::Kind kind, const char* name, Verdicts& verdicts) {
  std::vector<double> shares;
  for (const PoseSample& sample : poses.samples)
    if (sample.kind == kind) shares.push_back(100 * sample.range_error_m / sample.range_m);
  const Spread spread = spread_of(shares);
  // focal length and paint are known to 0.3 and 0.5 % in the simulated world: three times both together
  constexpr double limit_percent = 2;
  verdicts.add(spread.count, spread.p95 <= limit_percent, fmt::format("Range error of {}, all ranges", name),
               fmt::format("95 % within {:.1f} % of the range, median {:.1f} % ({} poses)", spread.p95,
                           spread.median, spread.count),
               fmt::format("95 % within {} %, what camera and paint explain", limit_percent));
}

void judge_poses(const PoseComparison& poses, Verdicts& verdicts) {
  for (const TableOneRow& row : table_one(poses)) {
    verdicts.add(
        row.ours.range_m.count, row.ours.range_m.median <= row.paper_error_m,
        fmt::format("Range error of circles near {:.2f} m", row.range_m),
        fmt::format("median {:.0f} mm, 95 % below {:.0f} mm ({} poses)", 1e3 * row.ours.range_m.median,
                    1e3 * row.ours.range_m.p95, row.ours.range_m.count),
        fmt::format("median at most the paper's {:.0f} mm", 1e3 * row.paper_error_m));
  }
  judge_ranges(poses, Mark::Kind::circle, "circles", verdicts);
  judge_ranges(poses, Mark::Kind::cargo, "cargo rims", verdicts);
  const PoseRow all = row_of("all", poses.samples);
  verdicts.add(all.judged, percent(all.wrong, all.judged) <= 0.5 && all.wrong_above_99 == 0,
               "The wrong one of two poses chosen",
               fmt::format("{:.2f} % of {}, {} of them with a probability above 0.99",
                           percent(all.wrong, all.judged), all.judged, all.wrong_above_99),
               "at most 0.5 % from 4 degrees of theta, none with a probability above 0.99");
  std::int64_t told = 0;
  for (const ProbabilityBin& bin : poses.probabilities) told += bin.count;
  verdicts.add(told, calibration_error(poses) < 0.02, "Published probability of a pose",
               fmt::format("off by {:.3f} in the mean", calibration_error(poses)), "below 0.02");
  const bool has_common = std::isfinite(all.nees3_with);
  const double nees3 = has_common ? all.nees3_with : all.nees3;
  verdicts.add(
      std::isfinite(nees3) ? all.range_m.count : 0, nees3 <= 1.25,
      has_common ? "Covariance of centres, with camera's and paint's errors" : "Covariance of centres",
      fmt::format("errors squared are {:.2f} times as large as told", nees3),
      "at most 1.25 (1: exact; below: careful)");
  verdicts.add(static_cast<std::int64_t>(poses.samples.size()), poses.switches == 0 && poses.taken_over == 0,
               "Track ids",
               fmt::format("{} changed within 2 s, {} went over to another mark ({} marks)", poses.switches,
                           poses.taken_over, poses.marks),
               "none");
}

void judge_platforms(const PlatformComparison& platforms, Verdicts& verdicts) {
  const SlotCounts& certain = platforms.certain;
  const std::int64_t told = certain.right + certain.wrong;
  verdicts.add(
      told + certain.unknown, certain.wrong == 0 && certain.misnumbered == 0,
      "Slots, while said to be certain",
      fmt::format("{} of {} wrong, {} at another slot's place", certain.wrong, told, certain.misnumbered),
      "none");
  verdicts.add(platforms.velocity_mps.count, platforms.velocity_mps.rms < 0.05, "Deck's velocity",
               fmt::format("{:.3f} m/s rms, all axes, below 6 m after 3 s in view ({} estimates)",
                           platforms.velocity_mps.rms, platforms.velocity_mps.count),
               "below 0.05 m/s");
  verdicts.add(platforms.predicted_m.count, platforms.predicted_m.rms < platforms.held_m.rms / 2,
               "Deck a second ahead",
               fmt::format("{:.2f} m rms; were it held to stand still {:.2f} m", platforms.predicted_m.rms,
                           platforms.held_m.rms),
               "at most half of what holding still gives");
}

/// has_truth: what was left out is known to be things; else it may hold vision's own errors, and is told.
void judge_altitude(const AltitudeComparison& altitudes, bool has_truth, Verdicts& verdicts) {
  const Spread &low = altitudes.vision_less_laser_low_m, &all = altitudes.vision_less_laser_m;
  const auto tell_left_out = [&](std::int64_t count) {
    if (!has_truth && count > 0)
      verdicts.list.back().text +=
          fmt::format("; left out: {} in which the laser is short of vision, on a thing or not", count);
  };
  verdicts.add(low.count, low.worst < 0.2, "Altitude below 2 m, vision against laser",
               fmt::format("worst {:.2f} m, rms {:.3f} m ({} frames)", low.worst, low.rms, low.count),
               "worst below 0.2 m, as in the paper's Fig. 9");
  tell_left_out(altitudes.on_thing_low);
  verdicts.add(all.count, all.p95 < 0.2, "Altitude at all heights, vision against laser",
               fmt::format("95 % within {:.2f} m, worst {:.2f} m ({} frames)", all.p95, all.worst, all.count),
               "95 % within 0.2 m");
  tell_left_out(altitudes.on_thing);
}

/// A frame without an answer has no latency: it is counted beside them.
void judge_latency(const Spread& late_ms, const Report& report, Verdicts& verdicts) {
  constexpr double most_unanswered_percent = 1;  // some are under way at the log's beginning and end
  const double limit_ms = 1e3 * channels::mission.max_age_s;
  const double unanswered_percent = percent(report.frames - report.answered, report.frames);
  verdicts.add(
      late_ms.count, late_ms.worst < limit_ms && unanswered_percent <= most_unanswered_percent,
      "From capture to MISSION",
      fmt::format("median {:.0f} ms, 95 % below {:.0f} ms, worst {:.0f} ms; {} of {} frames answered",
                  late_ms.median, late_ms.p95, late_ms.worst, report.answered, report.frames),
      fmt::format("worst below {:.0f} ms, the maximum age of MISSION; at most {} % of frames without "
                  "an answer",
                  limit_ms, most_unanswered_percent));
}

}  // namespace

std::vector<Verdict> verdicts_of(const Evaluation& evaluation) {
  Verdicts verdicts;
  if (evaluation.poses) judge_poses(*evaluation.poses, verdicts);
  if (evaluation.platforms) judge_platforms(*evaluation.platforms, verdicts);
  judge_altitude(evaluation.altitudes, evaluation.has_truth(), verdicts);
  judge_latency(evaluation.to_mission_ms, evaluation.flight.report, verdicts);
  return std::move(verdicts.list);
}

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Spread& spread) {
  if (spread.count == 0) return {{"count", 0}};
  return {{"count", spread.count},   {"mean", spread.mean}, {"rms", spread.rms},
          {"median", spread.median}, {"p95", spread.p95},   {"worst", spread.worst}};
}

Json to_json(const PoseRow& row) {
  return {{"name", row.name},
          {"range_error_m", to_json(row.range_m)},
          {"center_error_m", to_json(row.center_m)},
          {"judged", row.judged},
          {"wrong", row.wrong},
          {"wrong_above_099", row.wrong_above_99},
          {"nees3", row.nees3},
          {"nees3_with_common_errors", row.nees3_with}};
}

Json to_json(const std::vector<PoseRow>& rows) {
  Json list = Json::array();
  for (const PoseRow& row : rows) list.push_back(to_json(row));
  return list;
}

Json table_one_json(const PoseComparison& poses) {
  Json list = Json::array();
  for (const TableOneRow& row : table_one(poses)) {
    list.push_back({{"image", std::string(1, row.image)},
                    {"range_m", row.range_m},
                    {"paper_error_m", row.paper_error_m},
                    {"ours", to_json(row.ours)}});
  }
  return list;
}

Json to_json(const PoseComparison& poses) {
  Json bins = Json::array();
  for (const ProbabilityBin& bin : poses.probabilities)
    bins.push_back({{"count", bin.count}, {"right", bin.right}, {"sum", bin.sum}});
  return {{"frames", poses.frames},
          {"frames_without_marks", poses.frames_alone},
          {"frames_without_poses", poses.frames_unanswered},
          {"poses", poses.poses},
          {"compared", poses.samples.size()},
          {"of_nothing", poses.of_nothing},
          {"other_size", poses.other_size},
          {"doubled", poses.doubled},
          {"ambiguous", poses.ambiguous},
          {"without_solution", poses.without_solution},
          {"predicted", poses.predicted},
          {"whole_circles", poses.whole_circles},
          {"whole_circles_with_pose", poses.whole_found},
          {"ids",
           {{"marks", poses.marks},
            {"switches", poses.switches},
            {"new_after_exit", poses.after_exit},
            {"taken_over", poses.taken_over}}},
          {"all", to_json(row_of("all", poses.samples))},
          {"circles_by_range", to_json(rows_by_range(poses, Mark::Kind::circle))},
          {"circles_by_theta", to_json(rows_by_theta(poses))},
          {"by_mark", to_json(rows_by_mark(poses))},
          {"cargoes_by_range", to_json(rows_by_range(poses, Mark::Kind::cargo))},
          {"table_one", table_one_json(poses)},
          {"calibration_error", calibration_error(poses)},
          {"probability_bins", bins}};
}

Json to_json(const SlotCounts& slots) {
  return {{"right", slots.right},
          {"wrong", slots.wrong},
          {"unknown", slots.unknown},
          {"misnumbered", slots.misnumbered},
          {"handled", slots.handled}};
}

Json to_json(const PlatformComparison& platforms) {
  return {{"estimates", platforms.samples.size()},
          {"without_truth", platforms.without_truth},
          {"in_view", platforms.in_view},
          {"in_view_certain", platforms.in_view_certain},
          {"slots_certain", to_json(platforms.certain)},
          {"slots_uncertain", to_json(platforms.uncertain)},
          {"position_error_m", to_json(platforms.position_m)},
          {"velocity_error_mps", to_json(platforms.velocity_mps)},
          {"predicted_1s_error_m", to_json(platforms.predicted_m)},
          {"held_1s_error_m", to_json(platforms.held_m)},
          {"nees6", platforms.nees6}};
}

Json to_json(const AltitudeComparison& altitudes) {
  return {{"frames", altitudes.samples.size()},
          {"laser_on_thing", altitudes.on_thing},
          {"vision_less_laser_m", to_json(altitudes.vision_less_laser_m)},
          {"vision_less_laser_below_2m", to_json(altitudes.vision_less_laser_low_m)},
          {"vision_less_truth_m", to_json(altitudes.vision_less_truth_m)},
          {"laser_less_truth_m", to_json(altitudes.laser_less_truth_m)}};
}

Json to_json(const std::vector<Drop>& drops) {
  Json list = Json::array();
  for (const Drop& drop : drops) {
    list.push_back({{"utime", drop.utime},
                    {"cargo", drop.cargo},
                    {"platform", drop.platform},
                    {"slot", drop.slot},
                    {"off_m", drop.off_m},
                    {"tipped", drop.tipped},
                    {"circle_unseen_s", drop.unseen_s ? Json(*drop.unseen_s) : Json(nullptr)}});
  }
  return list;
}

const char* word_of(Verdict::Says says) {
  switch (says) {
    case Verdict::Says::good:
      return "good";
    case Verdict::Says::poor:
      return "poor";
    case Verdict::Says::nothing:
      break;
  }
  return "too few";
}

}  // namespace

Json to_json(const Evaluation& evaluation) {
  Json verdicts = Json::array();
  for (const Verdict& verdict : verdicts_of(evaluation)) {
    verdicts.push_back({{"says", word_of(verdict.says)},
                        {"subject", verdict.subject},
                        {"figure", verdict.text},
                        {"limit", verdict.limit}});
  }
  Json json{{"log", evaluation.log},
            {"duration_s", evaluation.flight.report.duration_s},
            {"frames", evaluation.flight.report.frames},
            {"unreadable", evaluation.flight.unreadable},
            {"has_truth", evaluation.has_truth()},
            {"verdicts", verdicts}};
  if (evaluation.poses) json["poses"] = to_json(*evaluation.poses);
  if (evaluation.platforms) json["platforms"] = to_json(*evaluation.platforms);
  if (evaluation.has_truth()) json["drops"] = to_json(evaluation.drops);
  if (evaluation.reference) {
    json["reference"] = to_json(*evaluation.reference);
    json["reference"]["log"] = evaluation.reference_log;
  }
  json["altitude"] = to_json(evaluation.altitudes);
  json["capture_to_poses_ms"] = to_json(evaluation.to_poses_ms);
  json["capture_to_mission_ms"] = to_json(evaluation.to_mission_ms);
  return json;
}

namespace {

std::string to_text(const PoseComparison& poses) {
  std::string text = fmt::format("{:<24}{:>8}{:>14}{:>12}{:>14}{:>10}{:>16}\n", "circles", "poses",
                                 "range, median", "95 %", "centre, med.", "wrong %", "theirs, range");
  const auto line = [&text](const PoseRow& row, const std::string& theirs) {
    text += fmt::format("{:<24}{:>8}{:>11.0f} mm{:>9.0f} mm{:>11.0f} mm{:>10.2f}{:>16}\n", row.name,
                        row.range_m.count, 1e3 * row.range_m.median, 1e3 * row.range_m.p95,
                        1e3 * row.center_m.median, percent(row.wrong, row.judged), theirs);
  };
  for (const TableOneRow& row : table_one(poses)) {
    PoseRow ours = row.ours;
    ours.name = fmt::format("Table 1 ({}), {:.2f} m", row.image, row.range_m);
    line(ours, fmt::format("{:.0f} mm", 1e3 * row.paper_error_m));
  }
  line(all_circles(poses), "");
  return text;
}

}  // namespace

std::string to_text(const Evaluation& evaluation) {
  std::string text;
  if (evaluation.poses) {
    text += to_text(*evaluation.poses) + "\n";
  } else {
    text += "No TRUTH in the log: only the laser, latencies and a second log can be compared with.\n\n";
  }
  if (evaluation.reference) {
    const Spread range_m = all_circles(*evaluation.reference).range_m;
    text += fmt::format(
        "Against {}: {} poses of circles, ranges differ by {:.0f} mm (median), {:.0f} mm (95 %).\n\n",
        evaluation.reference_log, range_m.count, 1e3 * range_m.median, 1e3 * range_m.p95);
  }
  for (const Verdict& verdict : verdicts_of(evaluation)) {
    text += fmt::format("{:<8} {}: {}\n", word_of(verdict.says), verdict.subject, verdict.text);
    if (verdict.says == Verdict::Says::poor) text += fmt::format("         wanted: {}\n", verdict.limit);
  }
  if (evaluation.flight.unreadable > 0)
    text += fmt::format("\n{} messages in the log can't be read: damaged, or of another version.\n",
                        evaluation.flight.unreadable);
  return text;
}

}  // namespace stevedore
