#include "runtime/kernel.hpp"

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>
#include <string>

namespace stevedore {
namespace {

std::set<std::string> own_socket_inodes() {
  std::set<std::string> inodes;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    const std::string target = std::filesystem::read_symlink(entry.path(), error).string();
    if (target.starts_with("socket:[")) inodes.insert(target.substr(8, target.size() - 9));
  }
  return inodes;
}

}  // namespace

int64_t kernel_udp_drops() {
  const auto inodes = own_socket_inodes();
  std::ifstream table("/proc/net/udp");
  std::string line;
  std::getline(table, line);  // heading
  int64_t drops = 0;
  while (std::getline(table, line)) {
    std::istringstream words(line);
    std::string word, inode;
    for (int column = 0; words >> word; ++column) {
      if (column == 9) inode = word;
    }
    if (inodes.contains(inode)) drops += std::stoll(word);  // the last column
  }
  return drops;
}

std::string name_in_this_network(const std::string& name, const std::string& bus_url) {
  struct stat network {};
  const std::string here =
      stat("/proc/self/ns/net", &network) == 0 ? name + "-" + std::to_string(network.st_ino) : name;
  return bus_url.empty() ? here : here + "-" + std::to_string(std::hash<std::string>{}(bus_url));
}

double cpu_time_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double resident_mb() {
  std::ifstream statm("/proc/self/statm");
  double total_pages = 0, resident_pages = 0;
  statm >> total_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

}  // namespace stevedore
