// Programs of this build, run as their users run them, and a folder for what they write.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace stevedore {

/// A folder of its own that goes with the test.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "stevedore_test_XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path_ = name;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

inline std::string text_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

struct ProgramRun {
  int status = -1;  ///< 128 and the signal's number for a program that was killed
  std::string out;
  std::string err;
};

/// A shell command; $BIN is the folder of the programs. Redirections in it go over what is caught here.
inline ProgramRun run_program(const std::string& command) {
  const Folder folder;
  const std::string line = "BIN='" STEVEDORE_BIN_DIR "'; { " + command + "\n} >'" + folder.file("out") +
                           "' 2>'" + folder.file("err") + "'";
  const int status = std::system(line.c_str());
  REQUIRE(WIFEXITED(status));
  return {WEXITSTATUS(status), text_of(folder.file("out")), text_of(folder.file("err"))};
}

}  // namespace stevedore
