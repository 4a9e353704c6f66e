// Pages that a program prints are what it prints today.
#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>

namespace {

std::string output_of(const std::string& command) {
  std::string text;
  std::FILE* pipe = popen((std::string(STEVEDORE_BIN_DIR) + "/" + command).c_str(), "r");
  REQUIRE(pipe);
  std::array<char, 4096> part{};
  for (size_t n; (n = std::fread(part.data(), 1, part.size(), pipe)) > 0;) text.append(part.data(), n);
  REQUIRE(pclose(pipe) == 0);
  return text;
}

std::string page(const std::string& name) {
  std::ostringstream text;
  text << std::ifstream(std::string(STEVEDORE_SOURCE_DIR) + "/docs/" + name).rdbuf();
  return text.str();
}

}  // namespace

TEST_CASE("docs/tuning.md is what settings prints") {
  CHECK(page("tuning.md") == output_of("settings"));
}

TEST_CASE("docs/messages.md ends with what doctor --channels prints") {
  const std::string table = output_of("doctor --channels");
  CHECK(table.size() > 1000);
  CHECK(page("messages.md").ends_with(table));
}
