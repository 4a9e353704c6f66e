#include "tools/report_core.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "lcmtypes/names.hpp"

namespace stevedore {
namespace {

/// Newest seq + 1 of each run: how many it had published by then, for seq counts from 0.
template <class Outputs>
std::map<int64_t, int64_t> published_by_run(const Outputs& outputs) {
  std::map<int64_t, int64_t> published;
  for (const auto& output : outputs) {
    published[output.run_id] = std::max(published[output.run_id], output.seq + 1);
  }
  return published;
}

/// Numbers that a run's messages in the log leave out, between its first and its last there.
template <class Outputs>
int64_t missing(const Outputs& outputs) {
  std::map<int64_t, std::set<int64_t>> seqs_by_run;
  for (const auto& output : outputs) seqs_by_run[output.run_id].insert(output.seq);
  int64_t count = 0;
  for (const auto& [run_id, seqs] : seqs_by_run) {
    count += *seqs.rbegin() - *seqs.begin() + 1 - static_cast<int64_t>(seqs.size());
  }
  return count;
}

}  // namespace

std::optional<Percentiles> percentiles_of(std::vector<int64_t> values_us) {
  if (values_us.empty()) return std::nullopt;
  std::sort(values_us.begin(), values_us.end());
  const auto at = [&values_us](double share) {
    const auto rank = std::lround(share * static_cast<double>(values_us.size() - 1));
    return static_cast<double>(values_us[static_cast<size_t>(rank)]) / 1e3;
  };
  return Percentiles{at(0.50), at(0.99)};
}

int64_t lost_of(const input_health_t& input) {
  return input.lost_gap + input.lost_malformed + input.lost_stale + input.lost_overwritten;
}

void HealthBook::add(const health_t& health) {
  const auto [newest, is_new] = processes_[health.process].try_emplace(health.header.trace.run_id, health);
  if (!is_new && health.header.seq > newest->second.header.seq) newest->second = health;
}

const HealthBook::Runs& HealthBook::runs_of(const std::string& process) const {
  static const Runs none;
  const auto found = processes_.find(process);
  return found == processes_.end() ? none : found->second;
}

std::array<StageLine, 5> stage_lines_of(const HealthBook& health) {
  auto lines = stage_lines;
  if (!health.runs_of("sim_proc").empty()) lines.front().process = "sim_proc";
  return lines;
}

template <class M>
void LogSummary::add_output(const LogEvent& event, const Channel<M>& channel) {
  const auto message = decode(event, channel);
  if (!message) {
    ++unreadable_;
    return;
  }
  const header_t& header = message->header;
  outputs_[channel.name].push_back(
      {header.trace.run_id, header.seq, header.utime, header.frame_seq, header.trace.publish_utime});
  if constexpr (std::is_same_v<M, tracks_t>) {
    if (message->target_status == track_t::STATUS_TRACKING) tracked_utimes_.insert(header.utime);
  }
  if constexpr (std::is_same_v<M, mission_t>) add_mission(*message, event.utime);
}

void LogSummary::add_mission(const mission_t& mission, int64_t log_utime) {
  const int64_t utime = mission.header.utime;
  low_altitude_.add(mission);
  emergencies_.emplace(log_utime, mission.emergencies);
  if (mission.has_setpoint) flown_since_utime_ = std::min(flown_since_utime_.value_or(utime), utime);
  if (mission.phase == mission_t::PHASE_COMPLETE) {
    complete_utime_ = std::min(complete_utime_.value_or(utime), utime);
    end_log_utime_ = std::min(end_log_utime_, log_utime);
  }
  if (!newest_mission_ || newest_mission_->header.utime <= utime) newest_mission_ = mission;
}

void LogSummary::add_truth(truth_t truth) {
  low_altitude_.add(truth);
  if (!first_truth_ || truth.header.utime < first_truth_->header.utime) first_truth_ = truth;
  if (!newest_truth_ || newest_truth_->header.utime <= truth.header.utime) newest_truth_ = std::move(truth);
}

std::optional<MissionReport> LogSummary::mission_report() const {
  if (!flown_since_utime_) return std::nullopt;
  MissionReport report;
  report.phase = phase_name(newest_mission_->phase);
  report.reason = newest_mission_->reason;
  report.told_delivered = newest_mission_->delivered;
  report.attempts = newest_mission_->attempts;
  const int64_t end_utime = complete_utime_.value_or(newest_mission_->header.utime);
  report.flown_s = static_cast<double>(end_utime - *flown_since_utime_) * 1e-6;
  if (newest_truth_) report.brought = brought_cargoes(*first_truth_, *newest_truth_);
  report.low_altitude = low_altitude_.sum_up();
  report.emergencies = emergency_reports();
  return report;
}

std::vector<EmergencyReport> LogSummary::emergency_reports() const {
  std::vector<EmergencyReport> reports;
  std::map<int16_t, size_t> raised;  // by kind: which report
  for (const auto& [log_utime, emergencies] : emergencies_) {
    if (log_utime > end_log_utime_) break;
    const double log_s = static_cast<double>(log_utime - *first_utime_) * 1e-6;
    std::map<int16_t, size_t> still;
    for (const emergency_t& each : emergencies) {
      const auto before = raised.find(each.kind);
      if (before == raised.end()) reports.push_back({each.kind, each.cause, log_s, std::nullopt});
      still[each.kind] = before == raised.end() ? reports.size() - 1 : before->second;
    }
    for (const auto& [kind, index] : raised)
      if (!still.contains(kind)) reports[index].cleared_s = log_s;
    raised = std::move(still);
  }
  return reports;
}

void LogSummary::add(const LogEvent& event) {
  first_utime_ = std::min(first_utime_.value_or(event.utime), event.utime);
  last_utime_ = std::max(last_utime_, event.utime);
  if (event.channel == channels::frame.name) return add_output(event, channels::frame);
  if (event.channel == channels::ellipses.name) return add_output(event, channels::ellipses);
  if (event.channel == channels::tracks.name) return add_output(event, channels::tracks);
  if (event.channel == channels::poses.name) return add_output(event, channels::poses);
  if (event.channel == channels::mission.name) return add_output(event, channels::mission);
  hear(event, channels::truth, [this](truth_t& truth) { add_truth(std::move(truth)); });
  hear(event, channels::platform_estimate, [this](const platform_estimate_t& m) { low_altitude_.add(m); });
  hear(event, channels::vehicle_state, [this](const vehicle_state_t& m) { low_altitude_.add(m); });
  hear(event, channels::health, [&](const health_t& health) { add_health(health, event.utime); });
}

template <class M, class Handler>
void LogSummary::hear(const LogEvent& event, const Channel<M>& channel, const Handler& handler) {
  if (event.channel != channel.name) return;
  if (auto message = decode(event, channel)) return handler(*message);
  ++unreadable_;
}

void LogSummary::add_health(const health_t& health, int64_t log_utime) {
  if (is_camera(health.process) && health.state == health_t::STATE_FINISHED)
    end_log_utime_ = std::min(end_log_utime_, log_utime);
  health_.add(health);
  const bool has_a_second_behind_it = health.header.seq > 0;
  if (has_a_second_behind_it) cpu_shares_[health.process].push_back(health.cpu_share);
}

std::optional<double> LogSummary::cpu_share_of(const std::string& process) const {
  const auto shares = cpu_shares_.find(process);
  if (shares == cpu_shares_.end()) return std::nullopt;
  return std::accumulate(shares->second.begin(), shares->second.end(), 0.0) /
         static_cast<double>(shares->second.size());
}

/// frame_seq counts what the camera owes, seq what it published; both from 0 in every run.
int64_t LogSummary::camera_drops() const {
  std::map<int64_t, int64_t> drops_by_run;
  for (const Output& frame : outputs_on(channels::frame.name)) {
    drops_by_run[frame.run_id] = std::max(drops_by_run[frame.run_id], frame.frame_seq - frame.seq);
  }
  int64_t drops = 0;
  for (const auto& [run_id, of_run] : drops_by_run) drops += of_run;
  return drops;
}

const LogSummary::Outputs& LogSummary::outputs_on(const std::string& channel) const {
  static const Outputs none;
  const auto found = outputs_.find(channel);
  return found == outputs_.end() ? none : found->second;
}

std::optional<Percentiles> LogSummary::stage_latency(const StageLine& line) const {
  std::unordered_map<int64_t, int64_t> answered_utime;  // by utime: when what is answered was published
  for (const Output& input : outputs_on(line.input)) {
    answered_utime.try_emplace(input.utime, input.publish_utime);
  }
  const bool is_camera = !*line.input;
  std::vector<int64_t> latencies_us;
  for (const Output& output : outputs_on(line.output)) {
    if (output.frame_seq < 0) continue;
    const auto answered = answered_utime.find(output.utime);
    if (is_camera) {  // files as fast as possible carry stamps of their own schedule, ahead of the clock
      latencies_us.push_back(std::max<int64_t>(0, output.publish_utime - output.utime));
    } else if (answered != answered_utime.end()) {
      latencies_us.push_back(output.publish_utime - answered->second);
    }
  }
  return percentiles_of(std::move(latencies_us));
}

StageReport LogSummary::stage_report(const StageLine& line) const {
  StageReport stage{};
  stage.process = line.process;
  stage.latency = stage_latency(line);
  stage.cpu_share = cpu_share_of(line.process);
  const Outputs& outputs = outputs_on(line.output);
  const HealthBook::Runs& runs = health_.runs_of(line.process);

  std::map<int64_t, int64_t> told;  // by run: published as of its last HEALTH
  for (const auto& [run_id, health] : runs) {
    int64_t& published = told[run_id];
    stage.kernel_drops = stage.kernel_drops.value_or(0) + health.kernel_drops;
    for (const auto& output : health.outputs) {
      if (output.channel == line.output) published = output.published;
    }
    stage.out += published;
    stage.lost = stage.lost.value_or(0);
    stage.skipped = stage.skipped.value_or(0);
    for (const auto& input : health.inputs) {
      if (input.channel != line.input && input.channel != line.frames_in) continue;
      if (!*line.input) stage.in += input.received;
      if (input.channel == line.input) {
        stage.in += input.received;
        stage.missed += lost_of(input) + input.skipped;
      }
      *stage.lost += lost_of(input);
      *stage.skipped += input.skipped;
    }
  }
  // a process that was killed had no last word: what it published after its last HEALTH is in the log
  for (const Output& output : outputs) {
    const bool untold = output.seq >= told.try_emplace(output.run_id, 0).first->second;
    if (untold) ++stage.out;
    if (untold && output.frame_seq >= 0) ++stage.in;
    if (output.frame_seq < 0) --stage.out;  // a MISSION that time alone caused answers no frame
  }
  stage.restarts = std::max<int64_t>(0, static_cast<int64_t>(told.size()) - 1);
  const bool is_camera = !*line.input;
  if (is_camera) {
    stage.in = std::max(stage.in, stage.out);
  } else if (runs.empty()) {
    stage.in = static_cast<int64_t>(outputs_on(line.input).size());
  }
  return stage;
}

StageReport LogSummary::beside_report(const std::string& process) const {
  StageReport beside{};
  beside.process = process;
  beside.cpu_share = cpu_share_of(process);
  const HealthBook::Runs& runs = health_.runs_of(process);
  beside.restarts = static_cast<int64_t>(runs.size()) - 1;
  beside.lost = beside.skipped = beside.kernel_drops = 0;
  for (const auto& [run_id, health] : runs) {
    *beside.kernel_drops += health.kernel_drops;
    for (const auto& input : health.inputs) {
      beside.in += input.received;
      *beside.lost += lost_of(input);
      *beside.skipped += input.skipped;
    }
    for (const auto& output : health.outputs) {
      if (output.channel != channels::health.name) beside.out += output.published;
    }
  }
  return beside;
}

Report LogSummary::report() const {
  Report report;
  report.duration_s = static_cast<double>(last_utime_ - first_utime_.value_or(last_utime_)) * 1e-6;
  for (const auto& [run_id, published] : published_by_run(outputs_on(channels::frame.name))) {
    report.frames += published;
  }
  std::unordered_map<int64_t, int64_t> sent_utime;
  for (const Output& frame : outputs_on(channels::frame.name))
    sent_utime.try_emplace(frame.utime, frame.publish_utime);
  std::map<int64_t, int64_t> latency_by_utime;
  for (const Output& mission : outputs_on(channels::mission.name)) {
    if (mission.frame_seq < 0) continue;
    const auto sent = sent_utime.find(mission.utime);
    const int64_t capture = sent == sent_utime.end() ? mission.utime : std::min(mission.utime, sent->second);
    latency_by_utime.try_emplace(mission.utime, mission.publish_utime - capture);
  }
  std::vector<int64_t> latencies_us;
  for (const auto& [utime, latency_us] : latency_by_utime) latencies_us.push_back(latency_us);
  report.answered = static_cast<int64_t>(latencies_us.size());
  report.latency = percentiles_of(std::move(latencies_us));
  report.tracked = static_cast<int64_t>(tracked_utimes_.size());
  int64_t missed = 0;
  for (const StageLine& line : stage_lines_of(health_)) {
    report.stages.push_back(stage_report(line));
    missed += report.stages.back().missed;
    report.frames_lost += report.stages.back().lost.value_or(0);
    report.frames_skipped += report.stages.back().skipped.value_or(0);
  }
  report.frames = std::max(report.frames, report.stages.front().out);  // FRAMEs that the log lacks
  report.unexplained = std::max<int64_t>(0, report.frames - report.answered - missed);
  for (const auto& [channel, outputs] : outputs_) report.missing_in_log += missing(outputs);
  report.unreadable = unreadable_;
  report.camera_drops = camera_drops();
  report.mission = mission_report();
  for (const auto& [process, runs] : health_.processes()) {
    const auto of_process = [&name = process](const StageReport& stage) { return stage.process == name; };
    const bool in_line = std::any_of(report.stages.begin(), report.stages.end(), of_process);
    if (!in_line) report.beside.push_back(beside_report(process));
    for (const auto& [run_id, health] : runs) {
      for (const auto& input : health.inputs) report.messages_lost += lost_of(input);
    }
  }
  return report;
}

namespace {

nlohmann::ordered_json to_json(const std::optional<Percentiles>& latency) {
  if (!latency) return {{"p50", nullptr}, {"p99", nullptr}};
  return {{"p50", latency->p50_ms}, {"p99", latency->p99_ms}};
}

template <class Number>
nlohmann::ordered_json to_json(const std::optional<Number>& number) {
  return number ? nlohmann::ordered_json(*number) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json to_json(const std::vector<EmergencyReport>& emergencies) {
  auto list = nlohmann::ordered_json::array();
  for (const EmergencyReport& each : emergencies) {
    list.push_back({{"kind", emergency_name(each.kind)},
                    {"cause", each.cause},
                    {"raised_s", each.raised_s},
                    {"cleared_s", to_json(each.cleared_s)}});
  }
  return list;
}

std::string to_text(const std::optional<int64_t>& count) {
  return count ? fmt::format("{}", *count) : "?";
}

std::string to_text(double latency_ms) {
  return fmt::format("{:.1f}", latency_ms);
}

/// Widths of the table's columns: process, in, out, lost, skipped, kernel drops, restarts, p50, p99, cpu.
constexpr const char* row_format = "{:<14}{:>8}{:>8}{:>7}{:>9}{:>14}{:>10}{:>9}{:>9}{:>7}\n";

std::string row(const StageReport& stage) {
  return fmt::format(fmt::runtime(row_format), stage.process, stage.in, stage.out, to_text(stage.lost),
                     to_text(stage.skipped), to_text(stage.kernel_drops), stage.restarts,
                     stage.latency ? to_text(stage.latency->p50_ms) : "-",
                     stage.latency ? to_text(stage.latency->p99_ms) : "-",
                     stage.cpu_share ? fmt::format("{:.0f}", 100 * *stage.cpu_share) : "?");
}

/// What keeps the figures from being the whole truth.
std::string remarks(const Report& report) {
  std::string text, unheard;
  for (const StageReport& stage : report.stages) {
    if (!stage.lost) unheard += (unheard.empty() ? "" : ", ") + stage.process;
  }
  if (!unheard.empty()) text += fmt::format("No HEALTH, so losses not known: {}.\n", unheard);
  if (report.unexplained > 0) {
    text += fmt::format(
        "{} frames had no answer though nobody counted them lost: a process was away, or the log is\n"
        "not complete.\n",
        report.unexplained);
  }
  const StageReport& camera = report.stages.front();
  if (camera.lost.value_or(0) > 0) {
    text += fmt::format("{} images could not be read or sent: {} says which in its log.\n", *camera.lost,
                        camera.process);
  }
  if (report.messages_lost > report.frames_lost) {
    text += fmt::format("{} messages that carry no frame were lost.\n",
                        report.messages_lost - report.frames_lost);
  }
  if (report.missing_in_log > 0) {
    text += fmt::format("{} messages of the line were published but are not in the log.\n",
                        report.missing_in_log);
  }
  if (report.unreadable > 0) {
    text += fmt::format("{} messages in the log can't be read: damaged, or of another version.\n",
                        report.unreadable);
  }
  return text;
}

nlohmann::ordered_json to_json(const std::vector<StageReport>& processes) {
  auto json = nlohmann::ordered_json::object();
  for (const StageReport& process : processes) {
    json[process.process] = {{"in", process.in},
                             {"out", process.out},
                             {"lost", to_json(process.lost)},
                             {"skipped", to_json(process.skipped)},
                             {"kernel_drops", to_json(process.kernel_drops)},
                             {"restarts", process.restarts},
                             {"latency_ms", to_json(process.latency)}};
  }
  return json;
}

}  // namespace

nlohmann::ordered_json to_json(const Report& report, const std::string& log) {
  nlohmann::ordered_json cpu_share;
  for (const auto* processes : {&report.stages, &report.beside}) {
    for (const StageReport& process : *processes) {
      if (process.cpu_share) cpu_share[process.process] = *process.cpu_share;
    }
  }
  nlohmann::ordered_json json{{"log", log},
                              {"duration_s", report.duration_s},
                              {"frames", report.frames},
                              {"frames_lost", report.frames_lost},
                              {"frames_skipped", report.frames_skipped},
                              {"camera_drops", report.camera_drops},
                              {"messages_lost", report.messages_lost},
                              {"tracked", report.tracked},
                              {"answered", report.answered},
                              {"latency_ms", to_json(report.latency)},
                              {"stages", to_json(report.stages)},
                              {"beside", to_json(report.beside)},
                              {"cpu_share", cpu_share},
                              {"missing_in_log", report.missing_in_log},
                              {"unreadable", report.unreadable}};
  if (const auto& mission = report.mission) {
    json["phase"] = mission->phase;
    json["delivered"] = mission->delivered();
    json["told_delivered"] = mission->told_delivered;
    json["attempts"] = mission->attempts;
    json["flown_s"] = mission->flown_s;
    json["drop_error_m"] = nullptr;
    if (mission->brought) {
      json["drop_error_m"] = nlohmann::ordered_json::array();
      for (const BroughtCargo& each : *mission->brought) json["drop_error_m"].push_back(each.off_m);
    }
    const LowAltitude& low = mission->low_altitude;
    json["altitude_error_below_2m_m"] = {{"p50", to_json(low.error_m(0.50))},
                                         {"p99", to_json(low.error_m(0.99))},
                                         {"max", to_json(low.error_m(1))}};
    json["altitude_share"] = {{"measured", to_json(low.share(low.measured))},
                              {"predicted", to_json(low.share(low.predicted))},
                              {"none", to_json(low.share(low.none))}};
    json["altitude_frames"] = low.frames();
    json["emergencies"] = to_json(mission->emergencies);
  }
  return json;
}

namespace {

/// By what was let go, how well the height was known, what went wrong: a line each, of what there is.
std::string to_text(const MissionReport& mission) {
  std::string text = fmt::format("\nMission: {} after {:.0f} s, {} delivered in {} attempts", mission.phase,
                                 mission.flown_s, mission.delivered(), mission.attempts);
  if (mission.told_delivered != mission.delivered())
    text += fmt::format("; by its own count {}", mission.told_delivered);
  text += mission.reason.empty() ? ".\n" : fmt::format(".\nIts last word: {}.\n", mission.reason);
  std::string drops;
  for (const BroughtCargo& each : mission.brought.value_or(std::vector<BroughtCargo>()))
    drops += fmt::format("{}{:.2f} (bucket {})", drops.empty() ? "" : ", ", each.off_m, each.cargo);
  if (!drops.empty()) text += fmt::format("Drop error, m: {}.\n", drops);
  const LowAltitude& low = mission.low_altitude;
  if (low.frames() > 0) {
    const auto percent = [&](int64_t frames) { return 100 * low.share(frames).value_or(0); };
    text += "Altitude below 2 m";
    if (!low.errors_m.empty()) {
      text += fmt::format(", error in m: {:.3f} (p50), {:.3f} (p99), {:.3f} at worst", *low.error_m(0.5),
                          *low.error_m(0.99), *low.error_m(1));
    }
    text += fmt::format(".\n  Of {} frames {:.1f} % measured, {:.1f} % predicted, {:.1f} % without.\n",
                        low.frames(), percent(low.measured), percent(low.predicted), percent(low.none));
  }
  std::map<std::string, int> times;
  for (const EmergencyReport& each : mission.emergencies) ++times[emergency_name(each.kind)];
  for (const auto& [kind, count] : times)
    text += fmt::format("Emergency: {}, {} time{}.\n", kind, count, count == 1 ? "" : "s");
  return text;
}

}  // namespace

std::string to_text(const Report& report) {
  std::string text = fmt::format(fmt::runtime(row_format), "", "in", "out", "lost", "skipped", "kernel drops",
                                 "restarts", "p50 ms", "p99 ms", "cpu %");
  for (const StageReport& stage : report.stages) text += row(stage);
  for (const StageReport& stage : report.beside) text += row(stage);
  text += fmt::format("\n{} frames in {:.1f} s: {} answered by MISSION, {} tracked, {} lost, {} skipped.\n",
                      report.frames, report.duration_s, report.answered, report.tracked, report.frames_lost,
                      report.frames_skipped);
  if (report.camera_drops > 0) {
    text += fmt::format("{} camera drops: frames that the camera owed and did not deliver.\n",
                        report.camera_drops);
  }
  if (report.latency) {
    text += fmt::format("Capture to MISSION: {} ms (p50), {} ms (p99).\n", to_text(report.latency->p50_ms),
                        to_text(report.latency->p99_ms));
  }
  if (report.mission) text += to_text(*report.mission);
  return text + remarks(report);
}

}  // namespace stevedore
