#include "tools/evaluate_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <utility>
#include <vector>

#include "tools/evaluate_plot.hpp"

namespace stevedore {
namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr const char *blue = "#1f77b4", *orange = "#e07b00", *green = "#2a8f3c", *red = "#c62828",
                     *grey = "#555";

constexpr const char* style = R"(<style>
:root{color-scheme:light}
body{font:15px/1.5 system-ui,"DejaVu Sans",sans-serif;color:#1c1f23;background:#fff;max-width:1160px;margin:0 auto;padding:20px}
h1{font-size:25px;margin:0}h2{font-size:19px;margin:34px 0 6px;border-bottom:2px solid #dde2e8;padding-bottom:3px}
p{max-width:900px;margin:6px 0 10px}.lead{color:#555;margin-top:2px}
table{border-collapse:collapse;margin:8px 0 14px;font-size:14px}th,td{padding:4px 11px;text-align:right;border-bottom:1px solid #e5e9ee}
th{background:#f3f5f8;font-weight:600;vertical-align:bottom}th:first-child,td:first-child{text-align:left}
table.v td{text-align:left}td.good,td.poor,td.none{white-space:nowrap}table.v th{text-align:left}
.good{color:#1b7a34;font-weight:700}.poor{color:#b71c1c;font-weight:700}.none{color:#777}
.plots{display:flex;flex-wrap:wrap;gap:14px}.plots svg{width:560px;max-width:100%;border:1px solid #e5e9ee;border-radius:4px}
svg text{font:12px system-ui,"DejaVu Sans",sans-serif;fill:#333}svg .h{font-size:14px;font-weight:600}svg .m{fill:#666}
svg .g{stroke:#e8ecf0}svg .z{stroke:#8a929b}
</style>)";

std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<table><tr>";
  for (const std::string& cell : head) html += fmt::format("<th>{}</th>", cell);
  html += "</tr>\n";
  for (const auto& row : rows) {
    html += "<tr>";
    for (const std::string& cell : row) html += fmt::format("<td>{}</td>", cell);
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

std::string plots(const std::vector<Plot>& list) {
  std::string html = "<div class=\"plots\">\n";
  for (const Plot& plot : list) html += svg_of(plot) + "\n";
  return html + "</div>\n";
}

std::string share(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? fmt::format("{:.1f} %", 100 * static_cast<double>(part) / static_cast<double>(whole))
                   : "-";
}

std::string millimetres(double value_m) {
  return fmt::format("{:.0f}", 1e3 * value_m);
}

std::string ratio(double value) {
  return std::isfinite(value) ? fmt::format("{:.2f}", value) : "-";
}

std::string verdict_section(const Evaluation& evaluation) {
  std::string html =
      "<h2>What is good, and what is not</h2>\n<table class=\"v\"><tr><th></th><th></th>"
      "<th>in this flight</th><th>wanted</th></tr>\n";
  for (const Verdict& verdict : verdicts_of(evaluation)) {
    const auto [kind, word] = verdict.says == Verdict::Says::good   ? std::pair("good", "good")
                              : verdict.says == Verdict::Says::poor ? std::pair("poor", "not met")
                                                                    : std::pair("none", "too few");
    html += fmt::format("<tr><td class=\"{}\">{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", kind, word,
                        escaped(verdict.subject), escaped(verdict.text), escaped(verdict.limit));
  }
  return html + "</table>\n";
}

std::string table_one_section(const PoseComparison& poses) {
  std::vector<std::vector<std::string>> rows;
  for (const TableOneRow& row : table_one(poses)) {
    const PoseRow& ours = row.ours;
    const bool any = ours.range_m.count > 0;
    rows.push_back({std::string(1, row.image), fmt::format("{:.3f}", row.range_m),
                    millimetres(row.paper_error_m), std::to_string(ours.range_m.count),
                    any ? millimetres(ours.range_m.median) : "-", any ? millimetres(ours.range_m.p95) : "-",
                    any ? fmt::format("{:+.0f}", 1e3 * ours.range_m.mean) : "-",
                    any ? millimetres(ours.center_m.median) : "-"});
  }
  return "<h2>The paper's Table 1</h2>\n<p>The paper measured the range to a circle one metre across in four "
         "still images, against a Vicon system, with the circle about parallel to the image. Beside its "
         "errors: "
         "those of this flight's circles within 10 % of the same range, moving, at every tilt.</p>\n" +
         table({"image", "range, m", "paper's error, mm", "our poses", "ours: median, mm", "95 % below, mm",
                "mean with sign, mm", "centre: median, mm"},
               rows);
}

std::string pose_table(const std::string& first, const std::vector<PoseRow>& rows) {
  std::vector<std::vector<std::string>> cells;
  for (const PoseRow& row : rows) {
    cells.push_back({row.name, std::to_string(row.range_m.count),
                     fmt::format("{:+.0f}", 1e3 * row.range_m.mean), millimetres(row.range_m.median),
                     millimetres(row.range_m.p95), millimetres(row.range_m.worst),
                     millimetres(row.center_m.median), millimetres(row.center_m.p95),
                     share(row.wrong, row.judged), ratio(row.nees3), ratio(row.nees3_with)});
  }
  return table(
      {first, "poses", "range error, mm:<br>mean", "<br>median", "<br>95 %", "<br>worst",
       "centre error, mm:<br>median", "<br>95 %", "wrong<br>solution", "NEES / 3", "with common<br>errors"},
      cells);
}

/// A value of each sample over another, right and wrong solutions apart.
template <class X, class Y>
Plot scatter(const PoseComparison& poses, std::string title, std::string x_label, std::string y_label,
             const X& x, const Y& y) {
  PlotSeries circles{"circles", blue, false, {}}, cargoes{"cargo rims", orange, false, {}},
      wrong{"wrong solution", red, false, {}};
  for (const PoseSample& sample : poses.samples) {
    const bool is_wrong = sample.is_wrong && sample.theta_rad >= 4 * deg;
    PlotSeries& series = is_wrong ? wrong : sample.kind == Mark::Kind::circle ? circles : cargoes;
    series.points.push_back({x(sample), y(sample)});
  }
  return {std::move(title), std::move(x_label), std::move(y_label), {circles, cargoes, wrong}};
}

std::string pose_plots(const PoseComparison& poses) {
  const auto range_m = [](const PoseSample& s) { return s.range_m; };
  const auto theta_deg = [](const PoseSample& s) { return s.theta_rad / deg; };
  const auto range_percent = [](const PoseSample& s) { return 100 * s.range_error_m / s.range_m; };
  // down to a tenth of a millimetre: no pose is better, and zero has no logarithm
  const auto center_log_mm = [](const PoseSample& s) {
    return std::log10(std::max(0.1, 1e3 * s.center_error_m));
  };
  const char* theta = "theta: circle's normal to line of sight, degrees";
  const char *range_error = "range error, % of the range", *center_error = "centre error, mm";
  std::vector<Plot> list{
      scatter(poses, "Range error over range", "range, m", range_error, range_m, range_percent),
      scatter(poses, "Centre error over range", "range, m", center_error, range_m, center_log_mm),
      scatter(poses, "Range error over theta", theta, range_error, theta_deg, range_percent),
      scatter(poses, "Centre error over theta", theta, center_error, theta_deg, center_log_mm)};
  list[1].is_log_y = list[3].is_log_y = true;
  return plots(list);
}

std::string probability_section(const PoseComparison& poses) {
  PlotSeries measured{"measured", blue, false, {}}, ideal{"as it should be", grey, true, {{0, 0}, {1, 1}}};
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < poses.probabilities.size(); ++i) {
    const ProbabilityBin& bin = poses.probabilities[i];
    if (bin.count == 0) continue;
    const double count = static_cast<double>(bin.count), right = static_cast<double>(bin.right) / count;
    measured.points.push_back({bin.sum / count, right});
    rows.push_back(
        {fmt::format("{:.1f} to {:.1f}", 0.1 * static_cast<double>(i), 0.1 * static_cast<double>(i + 1)),
         std::to_string(bin.count), fmt::format("{:.3f}", bin.sum / count), fmt::format("{:.3f}", right)});
  }
  Plot plot{"Published probability against how often it was right",
            "published",
            "share that was right",
            {ideal, measured}};
  plot.least_y = -0.05;
  plot.largest_y = 1.05;
  return fmt::format(
             "<h2>Which of the two poses</h2>\n<p>One image of a circle allows two poses. Each is published "
             "with the probability that it is the right one; over many, this should be the share that is. "
             "Here the two are {:.3f} apart in the mean (wanted: below 0.02).</p>\n",
             calibration_error(poses)) +
         table({"published", "solutions", "mean", "were right"}, rows) + plots({plot});
}

std::string match_section(const PoseComparison& poses, const std::string& what) {
  return fmt::format(
             "<p>A pose belongs to the mark that is nearest in direction (within half the mark's radius "
             "and 1 degree) and of about the same apparent size (a factor of 1.5). {} is compared by "
             "capture time.</p>\n",
             escaped(what)) +
         table(
             {"poses and marks", "count", ""},
             {{"frames compared", std::to_string(poses.frames), ""},
              {"frames with poses alone", std::to_string(poses.frames_alone), ""},
              {"frames without POSES, between the first and the last",
               std::to_string(poses.frames_unanswered),
               share(poses.frames_unanswered, poses.frames + poses.frames_unanswered)},
              {"measured poses", std::to_string(poses.poses), ""},
              {"of them compared", std::to_string(poses.samples.size()),
               share(static_cast<std::int64_t>(poses.samples.size()), poses.poses)},
              {"where nothing is (false, or a thing that is no mark)", std::to_string(poses.of_nothing),
               share(poses.of_nothing, poses.poses)},
              {"circle taken for a cargo's rim, or the other way", std::to_string(poses.other_size),
               share(poses.other_size, poses.poses)},
              {"second pose of the same mark", std::to_string(poses.doubled),
               share(poses.doubled, poses.poses)},
              {"two marks fit as well", std::to_string(poses.ambiguous), share(poses.ambiguous, poses.poses)},
              {"circles seen whole that have a pose", std::to_string(poses.whole_found),
               share(poses.whole_found, poses.whole_circles)},
              {"carried on without being seen (not compared)", std::to_string(poses.predicted), ""},
              {"seen, without a pose", std::to_string(poses.without_solution), ""},
              {"track id changed within 2 s", std::to_string(poses.switches), ""},
              {"new track id after longer absence (allowed)", std::to_string(poses.after_exit), ""},
              {"track id went over to another mark", std::to_string(poses.taken_over), ""}});
}

std::string pose_section(const PoseComparison& poses, const std::string& what) {
  return fmt::format("<h2>Poses against {}</h2>\n", escaped(what)) + match_section(poses, what) +
         pose_plots(poses) +
         "<p>Range error: how much farther away the mark is said to be than it is. Centre error: distance of "
         "the "
         "two centres, of the solution that was chosen. <b>NEES / 3</b>: squared error over what the "
         "published "
         "covariance tells, 1 if the covariance is exact. Those covariances hold the noise of the edges "
         "alone; "
         "focal length, principal point and the painted radius are slightly wrong all flight long. <b>With "
         "common "
         "errors</b>: these added as large as the simulated world draws them (0.3 %, 2 px, 0.5 %), less what "
         "the "
         "flight's settings put into the covariances already; one "
         "flight is "
         "one draw, so this may well be 0.3 or 2.</p>\n" +
         pose_table("circles by range", rows_by_range(poses, Mark::Kind::circle)) +
         pose_table("circles by theta", rows_by_theta(poses)) +
         pose_table("cargo rims by range", rows_by_range(poses, Mark::Kind::cargo)) +
         "<p>By mark; in the simulated world the last platform is the take-off pad.</p>\n" +
         pose_table("mark", rows_by_mark(poses));
}

double seconds_since(const Evaluation& evaluation, std::int64_t utime) {
  return static_cast<double>(utime - evaluation.flight.start_utime) * 1e-6;
}

std::vector<std::string> spread_row(const std::string& name, const Spread& spread, double unit) {
  if (spread.count == 0) return {name, "0", "-", "-", "-", "-", "-"};
  const auto text = [&](double value) { return fmt::format("{:.3f}", unit * value); };
  return {name,
          std::to_string(spread.count),
          fmt::format("{:+.3f}", unit * spread.mean),
          text(spread.rms),
          text(spread.median),
          text(spread.p95),
          text(spread.worst)};
}

std::string altitude_section(const Evaluation& evaluation) {
  constexpr double gap_s = 0.5;
  const AltitudeComparison& altitudes = evaluation.altitudes;
  if (altitudes.samples.empty())
    return "<h2>Altitude</h2>\n<p>No frame shows a circle whose height is known.</p>\n";
  PlotSeries truth{"truth", grey, true, {}, gap_s}, vision{"vision", blue, false, {}},
      laser{"laser", green, false, {}}, thing{"laser on a thing on the deck", red, false, {}},
      difference{"vision - laser", blue, false, {}}, off{"vision - truth", grey, false, {}};
  for (const AltitudeSample& sample : altitudes.samples) {
    const double t = seconds_since(evaluation, sample.utime);
    vision.points.push_back({t, sample.vision_m});
    if (sample.truth_m) truth.points.push_back({t, *sample.truth_m});
    if (sample.truth_m) off.points.push_back({*sample.truth_m, sample.vision_m - *sample.truth_m});
    if (!sample.laser_m) continue;
    (sample.on_thing ? thing : laser).points.push_back({t, *sample.laser_m});
    if (!sample.on_thing) difference.points.push_back({sample.vision_m, sample.vision_m - *sample.laser_m});
  }
  return "<h2>Altitude: vision against the laser</h2>\n<p>As in the paper's Fig. 9: height of the camera "
         "over the "
         "deck. The laser looks down from elsewhere on the aircraft and along its own axis, so its reading "
         "is "
         "carried over by the lever arm, the aircraft's tilt and the deck's. Only readings within 0.6 m of "
         "the middle of a circle in sight count. Where the beam falls on a thing on the deck (short by more "
         "than noise, and "
         "by "
         "no more than a person is tall) it is marked, and left out of the figures.</p>\n" +
         plots({{"Altitude in flight", "time, s", "camera over the deck, m", {truth, vision, laser, thing}},
                {"Differences over altitude", "altitude, m", "difference, m", {off, difference}}}) +
         table({"difference, m", "frames", "mean", "rms", "median", "95 %", "worst"},
               {spread_row("vision - laser", altitudes.vision_less_laser_m, 1),
                spread_row("vision - laser, below 2 m", altitudes.vision_less_laser_low_m, 1),
                spread_row("vision - truth", altitudes.vision_less_truth_m, 1),
                spread_row("laser - truth", altitudes.laser_less_truth_m, 1)}) +
         fmt::format("<p>{} laser readings on a cargo or another thing, {}.</p>\n", altitudes.on_thing,
                     evaluation.has_truth() ? "by TRUTH" : "if vision does not read high there");
}

std::string platform_section(const Evaluation& evaluation) {
  const PlatformComparison& platforms = *evaluation.platforms;
  PlotSeries velocity{"velocity", blue, false, {}}, predicted{"predicted", blue, false, {}},
      held{"held to stand still", orange, false, {}};
  for (const PlatformSample& sample : platforms.samples) {
    if (!sample.in_view_s) continue;
    const double t = seconds_since(evaluation, sample.utime);
    velocity.points.push_back({t, sample.velocity_error_mps});
    if (sample.predicted_error_m) predicted.points.push_back({t, *sample.predicted_error_m});
    if (sample.held_error_m) held.points.push_back({t, *sample.held_error_m});
  }
  const auto slots = [](const std::string& name, const SlotCounts& counts) -> std::vector<std::string> {
    return {name,
            std::to_string(counts.right),
            std::to_string(counts.wrong),
            std::to_string(counts.unknown),
            std::to_string(counts.misnumbered),
            std::to_string(counts.handled)};
  };
  return "<h2>Platforms and slots</h2>\n<p>Where decks are, relative to the aircraft; how fast they move "
         "over "
         "ground; where they will be in a second. In the table: below 6 m and after 3 s in view, which is "
         "what "
         "lowering a load needs. In the plots: whenever the deck is in view.</p>\n" +
         plots({{"Error of a deck's velocity", "time, s", "error, m/s", {velocity}},
                {"Error of a deck's place a second ahead", "time, s", "error, m", {held, predicted}}}) +
         table({"error", "estimates", "mean", "rms", "median", "95 %", "worst"},
               {spread_row("position, m", platforms.position_m, 1),
                spread_row("velocity, m/s", platforms.velocity_mps, 1),
                spread_row("a second ahead, m", platforms.predicted_m, 1),
                spread_row("the same, held to stand still, m", platforms.held_m, 1)}) +
         fmt::format("<p>NEES / 6 of position and velocity: {} (1: covariance exact; below: careful).</p>\n",
                     ratio(platforms.nees6)) +
         "<p>What is said of the slots, counted for each slot and frame: while slot numbers are said to be "
         "certain, "
         "and else.</p>\n" +
         table({"slots", "right", "wrong", "unknown", "at another slot's place", "being lifted or set down"},
               {slots("while certain", platforms.certain), slots("while uncertain", platforms.uncertain)}) +
         fmt::format("<p>Slot numbers are certain in {} of the {} estimates of a deck in view.</p>\n",
                     share(platforms.in_view_certain, platforms.in_view), platforms.in_view);
}

std::string drop_section(const Evaluation& evaluation) {
  std::vector<std::vector<std::string>> rows;
  PlotSeries drops{"drops", blue, false, {}};
  for (const Drop& drop : evaluation.drops) {
    rows.push_back({fmt::format("{:.0f}", seconds_since(evaluation, drop.utime)), std::to_string(drop.cargo),
                    name_of_circle(drop.platform, drop.slot),
                    fmt::format("{:.3f}{}", drop.off_m, drop.tipped ? " (tipped)" : ""),
                    drop.unseen_s ? fmt::format("{:.1f}", *drop.unseen_s) : "never"});
    if (drop.unseen_s) drops.points.push_back({*drop.unseen_s, drop.off_m});
  }
  if (rows.empty()) return "<h2>Drops</h2>\n<p>No cargo was brought to another platform.</p>\n";
  return "<h2>Drops</h2>\n<p>Each cargo that was let go over another platform than its own: how far its axis "
         "then "
         "stands from the middle of the nearest circle, and for how long that circle's own pose had not been "
         "measured, being cut by the image's edge or under the nose.</p>\n" +
         table({"let go, s", "cargo", "circle", "off its middle, m", "circle not measured for, s"}, rows) +
         plots({{"Drop error over the time without the circle",
                 "circle not measured for, s",
                 "off, m",
                 {drops}}});
}

std::string latency_section(const Evaluation& evaluation) {
  const auto row = [](const std::string& name, const Spread& spread) -> std::vector<std::string> {
    return {name, std::to_string(spread.count), fmt::format("{:.1f}", spread.median),
            fmt::format("{:.1f}", spread.p95), fmt::format("{:.1f}", spread.worst)};
  };
  std::vector<std::vector<std::string>> stages;
  for (const StageReport& stage : evaluation.flight.report.stages) {
    stages.push_back({stage.process, std::to_string(stage.in), std::to_string(stage.out),
                      stage.latency ? fmt::format("{:.1f}", stage.latency->p50_ms) : "-",
                      stage.latency ? fmt::format("{:.1f}", stage.latency->p99_ms) : "-"});
  }
  return "<h2>Latency</h2>\n<p>From the capture of a frame to the answer to it, and what each process takes "
         "of "
         "that.</p>\n" +
         table({"from capture, ms", "frames", "median", "95 %", "worst"},
               {row("to POSES", evaluation.to_poses_ms), row("to MISSION", evaluation.to_mission_ms)}) +
         table({"process", "frames in", "frames out", "median, ms", "99 %, ms"}, stages);
}

}  // namespace

std::string to_html(const Evaluation& evaluation) {
  const std::string name = escaped(std::filesystem::path(evaluation.log).filename().string());
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Evaluation of "
      "{0}</title>\n{1}</head>"
      "<body>\n<h1>How well the flight saw</h1>\n<p class=\"lead\">{0}: {2:.0f} s, {3} frames. {4}</p>\n",
      name, style, evaluation.flight.report.duration_s, evaluation.flight.report.frames,
      evaluation.has_truth()
          ? "Against the truth of the simulated world, and its laser."
          : "The log has no TRUTH: only the laser, latencies and a second log can be compared "
            "with.");
  if (evaluation.flight.unreadable > 0)
    html += fmt::format("<p>{} messages in the log can't be read: damaged, or of another version.</p>\n",
                        evaluation.flight.unreadable);
  html += verdict_section(evaluation);
  if (evaluation.poses)
    html += table_one_section(*evaluation.poses) + pose_section(*evaluation.poses, "TRUTH");
  if (evaluation.poses) html += probability_section(*evaluation.poses);
  if (evaluation.reference) html += pose_section(*evaluation.reference, evaluation.reference_log);
  html += altitude_section(evaluation);
  if (evaluation.platforms) html += platform_section(evaluation) + drop_section(evaluation);
  return html + latency_section(evaluation) + "</body></html>\n";
}

}  // namespace stevedore
