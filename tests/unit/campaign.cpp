#include "tools/campaign_lines.hpp"

#include <csignal>

#include "runtime/command_line.hpp"
#include "tests/support/program.hpp"
#include "tools/campaign_core.hpp"

using namespace stevedore;
using Catch::Contains;
using Seeds = std::vector<std::int64_t>;

namespace {

MissionLine line(std::int64_t seed, int delivered, const std::string& cause = "") {
  MissionLine l;
  l.seed = seed;
  l.sea_state = static_cast<int>(seed % 4);
  l.delivered = delivered;
  l.of = 4;
  l.attempts = 5;
  l.duration_s = 310.25;
  l.flown_s = 309.5;
  l.drop_error_m.assign(static_cast<std::size_t>(delivered), 0.05);
  l.cause = cause;
  l.wall_s = 120;
  return l;
}

void write(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

Seeds seeds_of(const std::vector<MissionLine>& lines) {
  Seeds seeds;
  for (const MissionLine& l : lines) seeds.push_back(l.seed);
  return seeds;
}

mission_t mission(int phase, const std::string& reason, int delivered = 0,
                  std::vector<int> emergencies = {}) {
  mission_t m{};
  m.phase = static_cast<std::int8_t>(phase);
  m.reason = reason;
  m.delivered = static_cast<std::int16_t>(delivered);
  for (const int kind : emergencies) {
    emergency_t e{};
    e.kind = static_cast<std::int16_t>(kind);
    e.cause = "why";
    m.emergencies.push_back(e);
  }
  m.emergency_count = static_cast<std::int16_t>(m.emergencies.size());
  return m;
}

const std::string fly = "$BIN/campaign --config " STEVEDORE_SOURCE_DIR "/config/world.yaml ";

}  // namespace

TEST_CASE("Wilson's interval has its known values") {
  // R. G. Newcombe, Two-sided confidence intervals for the single proportion, Stat. Med. 17 (1998), table I,
  // method 3
  const auto check = [](int successes, int trials, double low, double high) {
    INFO(successes << " of " << trials);
    CHECK(wilson_interval(successes, trials).low == Approx(low).margin(5e-5));
    CHECK(wilson_interval(successes, trials).high == Approx(high).margin(5e-5));
  };
  check(81, 263, 0.2553, 0.3662);
  check(15, 148, 0.0624, 0.1605);
  check(0, 20, 0, 0.1611);
  check(1, 29, 0.0061, 0.1718);
  CHECK(wilson_interval(20, 20).low == Approx(1 - 0.1611).margin(5e-5));
  CHECK(wilson_interval(20, 20).high == 1);
  CHECK(wilson_interval(0, 0).low == 0);
  CHECK(wilson_interval(0, 0).high == 1);
}

TEST_CASE("a line says the same when it is read again") {
  MissionLine one = line(7, 3, "cargo lost (the \"hook\"\nbears nothing)");
  one.drop_error_m = {0.0413, 0.1, 0.2001};
  const std::string text = to_json_line(one);
  CHECK(text.find('\n') == std::string::npos);
  CHECK_THAT(text,
             Contains(R"("seed":7,"sea_state":3,"delivered":3,"of":4,"attempts":5,"duration_s":310.25)"));
  const auto again = mission_line_of(text);
  REQUIRE(again);
  CHECK(to_json_line(*again) == text);
  CHECK(again->cause == one.cause);
  CHECK(again->drop_error_m == one.drop_error_m);
  CHECK_FALSE(mission_line_of(""));
  CHECK_FALSE(mission_line_of("{}"));
  CHECK_FALSE(mission_line_of("17"));
  for (std::size_t bytes = 0; bytes < text.size(); ++bytes)
    CHECK_FALSE(mission_line_of(text.substr(0, bytes)));
}

TEST_CASE("a torn last line is dropped, a damaged one before it is not passed over") {
  const std::string one = to_json_line(line(1, 4)) + "\n", two = to_json_line(line(2, 4));
  CHECK(parse_mission_lines("", "f").lines.empty());
  CHECK(seeds_of(parse_mission_lines(one + two + "\n", "f").lines) == Seeds{1, 2});
  for (std::size_t bytes = 0; bytes < two.size(); ++bytes) {
    const auto torn = parse_mission_lines(one + two.substr(0, bytes), "f");
    CHECK(seeds_of(torn.lines) == Seeds{1});
    CHECK(torn.sound_bytes == one.size());
    CHECK(torn.is_closed);
    CHECK(torn.is_torn == (bytes > 0));
  }
  const auto open = parse_mission_lines(one + two, "f");
  CHECK(seeds_of(open.lines) == Seeds{1, 2});
  CHECK_FALSE(open.is_closed);
  const std::string merged = one + two.substr(0, 20) + one + one;
  CHECK_THROWS_WITH(parse_mission_lines(merged, "f"), Contains("f:2: not a campaign's line"));
}

TEST_CASE("a campaign's file goes on where it was torn, and is one campaign's") {
  const Folder folder;
  const std::string path = folder.file("c.jsonl"), one = to_json_line(line(1, 4)),
                    two = to_json_line(line(2, 3, "late"));
  for (const std::string& there :
       {one + "\n" + two.substr(0, 30), one, one + "\n", one + "\n" + two.substr(0, 30) + "\n"}) {
    INFO(there);
    write(path, there);
    {
      MissionFile file(path);
      CHECK(seeds_of(file.lines()) == Seeds{1});
      file.add(line(2, 3, "late"));
      CHECK(seeds_of(file.lines()) == Seeds{1, 2});
      CHECK_THROWS_WITH(MissionFile(path), Contains("another campaign writes to it"));
    }
    CHECK(text_of(path) == one + "\n" + two + "\n");
  }
  CHECK_THROWS_WITH(MissionFile(folder.file("no/where")), Contains("can't be written"));
}

TEST_CASE("a file that is no campaign's is left as it is") {
  const Folder folder;
  const std::string path = folder.file("notes"), one = to_json_line(line(1, 4));
  for (const std::string& there : {std::string("remember the milk\n"), std::string("{}"), one + "\nmilk"}) {
    INFO(there);
    write(path, there);
    CHECK_THROWS_WITH(MissionFile(path), Contains("not a campaign's line") && Contains("name another"));
    CHECK(text_of(path) == there);
  }
  write(path, one + "\n" + one.substr(0, 30));
  const auto sum = run_program("$BIN/campaign --summary " + path);
  CHECK(sum.status == 0);
  CHECK_THAT(sum.out, Contains("1 of 1") && Contains("left out: a torn last line of " + path));
}

TEST_CASE("shards share the seeds out, and what has a line is not flown again") {
  const auto seeds = [](const std::string& shard, const std::vector<MissionLine>& done = {}) {
    return seeds_to_fly(10, 7, parse_shard(shard), done);
  };
  CHECK(seeds("1/1") == Seeds{10, 11, 12, 13, 14, 15, 16});
  CHECK(seeds("1/3") == Seeds{10, 13, 16});
  CHECK(seeds("2/3") == Seeds{11, 14});
  CHECK(seeds("3/3") == Seeds{12, 15});
  CHECK(seeds("8/9").empty());
  CHECK(seeds("1/3", {line(13, 4), line(99, 4)}) == Seeds{10, 16});
  CHECK(seeds("1/1", {line(10, 0, "late"), line(16, 4)}) == Seeds{11, 12, 13, 14, 15});
  for (const char* bad : {"", "1", "0/2", "3/2", "-1/2", "1/2/3", "a/b", "1/", "/2", "1 /2", "1/0"}) {
    INFO(bad);
    CHECK_THROWS_AS(parse_shard(bad), UsageError);
  }
}

TEST_CASE("a summary counts missions, cargoes and causes") {
  std::vector<MissionLine> lines;
  for (int seed = 1; seed <= 29; ++seed) lines.push_back(line(seed, 4));
  lines.push_back(line(30, 3, "cargo lost (the hook bears nothing any more)"));
  const std::string text = summary_of(lines);
  CHECK_THAT(text, Contains("missions with all delivered: 29 of 30 (96.7 %; Wilson 95 %: 83.3 to 99.4 %)"));
  CHECK_THAT(text, Contains("sea state 1: 8 of 8") && Contains("sea state 2: 7 of 8"));
  CHECK_THAT(text, Contains("cargoes: 119 of 120 delivered, in 150 attempts"));
  CHECK_THAT(text, Contains("drop error: mean 0.050 m, worst 0.050 m"));
  CHECK_THAT(text, Contains("1 x cargo lost: seed 30"));
  CHECK_THAT(text, Contains("30.0 missions an hour with one worker"));
  CHECK_THAT(text, !Contains("left out"));

  lines.push_back(line(31, 0, "cargo lost (in the wind)"));
  lines.push_back(line(32, 2, "time is up (in approach; before: cargo lost (why))"));
  lines.push_back(line(32, 4));
  const std::string more = summary_of(lines);
  CHECK_THAT(more, Contains("29 of 32") && Contains("2 x cargo lost: seed 30 31") &&
                       Contains("1 x time is up: seed 32"));
  CHECK_THAT(more, Contains("left out: 1 lines of seeds"));
  CHECK(summary_of({}) == "no mission was flown\n");
}

TEST_CASE("the cause is what cost a cargo, else what went wrong last, else that time is up") {
  CauseBook book;
  book.add(mission(mission_t::PHASE_TAKE_OFF, ""));
  CHECK(book.cause() == "time is up (in take-off)");
  book.add(mission(mission_t::PHASE_VERIFY_LOAD, "lifts", 0, {emergency_t::KIND_ALTITUDE_DISAGREES}));
  CHECK(book.cause() == "time is up (in verify load; before: altitude disagrees (why))");
  book.add(mission(mission_t::PHASE_RETRY, "the hook bears nothing"));
  CHECK(book.cause() == "time is up (in retry; before: verify load failed (the hook bears nothing))");
  book.add(mission(mission_t::PHASE_VERIFY_DROP, "let go"));
  book.add(mission(mission_t::PHASE_TRANSIT, "the cargo stands in its circle", 1));
  CHECK_THAT(book.cause(), Contains("before: verify load failed"));
  book.add(mission(mission_t::PHASE_VERIFY_DROP, "let go", 1));
  book.add(mission(mission_t::PHASE_TRANSIT, "nobody saw where the cargo went", 1));
  CHECK_THAT(book.cause(), Contains("before: verify drop failed (nobody saw"));
  book.add(mission(mission_t::PHASE_TRANSIT, "", 1, {emergency_t::KIND_CARGO_LOST}));
  book.add(mission(mission_t::PHASE_TRANSIT, "the cargo is lost", 1, {emergency_t::KIND_CARGO_LOST}));
  book.add(mission(mission_t::PHASE_RETRY, "late", 1));
  book.add(mission(mission_t::PHASE_RETURN, "goes home: 1 of 4 delivered", 1));
  book.add(mission(mission_t::PHASE_COMPLETE, "landed", 1));
  CHECK(book.cause() == "cargo lost (why); goes home: 1 of 4 delivered");
  CHECK(kind_of_cause(book.cause()) == "cargo lost");
}

TEST_CASE("campaign resumes, shards merge, and a worker that fails is a mission that failed") {
  const Folder folder;
  const std::string out = folder.file("c.jsonl"), other = folder.file("d.jsonl");
  const std::string very_short = fly + "--longest 0.1 --jobs 2 --missions 4 --seed 8 ";
  // what is there already: one mission, and half a line
  write(out, to_json_line(line(10, 4)) + "\n{\"seed\":8,");
  const auto first = run_program(very_short + "--shard 1/2 --out " + out);
  CHECK(first.status == 0);
  CHECK_THAT(first.out, Contains("1 of 1 flown") && Contains("missions with all delivered: 1 of 2"));
  const auto again = run_program(very_short + "--shard 1/2 --out " + out);
  CHECK(again.status == 0);
  CHECK_THAT(again.out, Contains("0 missions to fly"));
  CHECK(run_program(very_short + "--shard 2/2 --set sim.cargoes=3 --out " + other).status == 0);
  CHECK(seeds_of(read_mission_lines(out).lines) == Seeds{10, 8});
  const auto flown = read_mission_lines(other).lines;
  REQUIRE(flown.size() == 2);
  CHECK(flown[0].of == 3);
  CHECK(flown[0].sea_state == flown[0].seed % 4);
  CHECK(flown[0].cause == "time is up (in idle)");
  CHECK(flown[0].wall_s > 0);

  const auto sum = run_program("cat " + out + " " + other + " >" + folder.file("all") +
                               " && $BIN/campaign --summary " + folder.file("all"));
  CHECK(sum.status == 0);
  CHECK_THAT(sum.out, Contains("1 of 4 (25.0 %") && Contains("3 x time is up: seed"));
  const auto both = run_program("$BIN/campaign --summary " + out + " " + other);
  CHECK(both.out == sum.out);
}

TEST_CASE("a worker that is killed, or can't fly, has its cause in the line") {
  const Folder folder;
  const std::string out = folder.file("c.jsonl");
  // a second of CPU is not enough for 1000 s of flight: the kernel ends the worker
  const auto killed =
      run_program("( ulimit -t 1; " + fly + "--missions 1 --longest 1000 --out " + out + " )");
  CHECK(killed.status == 1);
  const auto lines = read_mission_lines(out).lines;
  REQUIRE(lines.size() == 1);
  CHECK(lines[0].delivered == 0);
  CHECK(lines[0].of == 4);
  CHECK_THAT(lines[0].cause, Contains("worker ended by signal"));
  CHECK_THAT(killed.out, Contains("1 x worker ended by signal"));

  const auto mistake = run_program(fly + "--missions 3 --set sim.nonsense=1 --out " + folder.file("d.jsonl"));
  CHECK(mistake.status == 2);
  CHECK_THAT(mistake.err, Contains("nonsense"));
  CHECK(text_of(folder.file("d.jsonl")).empty());
}

TEST_CASE("a campaign that is stopped records nothing half done, and its workers end with it") {
  const Folder folder;
  const std::string out = folder.file("c.jsonl");
  const std::string log = folder.file("log");
  const auto run =
      run_program(fly + "--missions 2 --jobs 2 --longest 1000 --out " + out + " >" + log +
                  " & until grep -q 'to fly' " + log + "; do sleep 0.1; done; kill -TERM $!; wait $!");
  CHECK(run.status == exit_stopped);
  CHECK_THAT(text_of(log), Contains("stopped: the same command goes on"));
  CHECK(text_of(out).empty());
}

TEST_CASE("campaign: mistakes and files that can't be used") {
  const Folder folder;
  CHECK(run_program("$BIN/campaign --missions 2").status == 2);
  CHECK(run_program("$BIN/campaign").status == 2);
  CHECK(run_program(fly + "--missions 0").status == 2);
  CHECK(run_program(fly + "--missions 2 --shard 3/2 --out " + folder.file("c")).status == 2);
  CHECK(run_program(fly + "--missions 2 --json").status == 2);
  CHECK(run_program(fly + "--jobs 2").status == 2);
  CHECK(run_program("$BIN/campaign --summary " + folder.file("none")).status == 2);
  write(folder.file("empty"), "");
  const auto empty = run_program("$BIN/campaign --summary " + folder.file("empty"));
  CHECK(empty.status == 1);
  CHECK_THAT(empty.err, Contains("no mission's line"));
  CHECK(run_program(fly + "--missions 1 --longest 0.1 --out " + folder.file("no/where")).status == 1);
}
