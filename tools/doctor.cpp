// Says whether this machine can run the set, and what to do where it can't.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include <fmt/format.h>

#include "lcmtypes/channels.hpp"
#include "runtime/process.hpp"
#include "tools/doctor_checks.hpp"

using namespace stevedore;

namespace {

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::ok:
      return "ok";
    case Verdict::limited:
      return "limited";
    case Verdict::fix:
      return "fix";
  }
  return "";
}

void print_lines(const std::vector<Finding>& findings) {
  for (const Finding& finding : findings) {
    fmt::print("{}  {:<24}{}{}\n", finding.verdict == Verdict::ok ? "ok " : "FIX", finding.what, finding.text,
               finding.verdict == Verdict::limited ? " (the set runs without)" : "");
  }
}

void print_json(const std::vector<Finding>& findings) {
  nlohmann::json list = nlohmann::json::array();
  for (const Finding& finding : findings) {
    list.push_back({{"what", finding.what}, {"verdict", name_of(finding.verdict)}, {"text", finding.text}});
  }
  fmt::print("{}\n", list.dump(2));
}

std::string number_or_dash(double value, const char* unit) {
  return value > 0 ? fmt::format("{} {}", value, unit) : "-";
}

void print_channels() {
  fmt::print(
      "| channel | type | publisher | nominal rate | maximum age | logged |\n|---|---|---|---|---|---|\n");
  for (const ChannelInfo& channel : channel_table()) {
    fmt::print("| {} | {} | {} | {} | {} | {} |\n", channel.name, channel.type, channel.publisher,
               number_or_dash(channel.rate_hz, "Hz"), number_or_dash(channel.max_age_s, "s"),
               channel.logged ? "yes" : "no");
  }
}

int run(int argc, char** argv) {
  CLI::App app("Says whether this machine can run the set, and what to do where it can't.", "doctor");
  bool json = false, channels = false;
  app.add_flag("--json", json, "the findings as a JSON list of what, verdict (ok, limited or fix), text");
  app.add_flag("--channels", channels, "only print the table of channels, as Markdown");
  parse_command_line(app, argc, argv, "else how many things keep the set from running");
  if (channels) {
    print_channels();
    return 0;
  }
  const std::vector<Finding> findings = all_findings();
  json ? print_json(findings) : print_lines(findings);
  return static_cast<int>(std::count_if(findings.begin(), findings.end(),
                                        [](const Finding& f) { return f.verdict == Verdict::fix; }));
}

}  // namespace

int main(int argc, char** argv) {
  return guarded_main([&] { return run(argc, argv); });
}
