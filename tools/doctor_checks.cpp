#include "tools/doctor_checks.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <ifaddrs.h>
#include <linux/videodev2.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <sstream>

#include "runtime/file_descriptor.hpp"
#include "runtime/frame_codec.hpp"
#include "runtime/lcm_bus.hpp"

namespace stevedore {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t lcm_group = (239U << 24) + (255U << 16) + (76U << 8) + 67U;  // of default_lcm_url
constexpr long wanted_receive_buffer_bytes = 2'097'152;                         // its recv_buf_size
constexpr long needed_receive_buffer_bytes = 4L * inline_limit_bytes;
/// A ring of sixteen 1280x960 colour frames.
constexpr double needed_shared_memory_mb = 64;

/// Numbers of /proc/net/route: addresses in network byte order, printed as a little-endian number.
uint32_t address_of(const std::string& hex) {
  return __builtin_bswap32(static_cast<uint32_t>(std::strtoul(hex.c_str(), nullptr, 16)));
}

std::string content_of(const fs::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

Finding check_loopback() {
  ifaddrs* first = nullptr;
  bool up = false;
  if (getifaddrs(&first) == 0) {
    for (const ifaddrs* i = first; i != nullptr; i = i->ifa_next) {
      up = up || ((i->ifa_flags & IFF_LOOPBACK) != 0 && (i->ifa_flags & IFF_UP) != 0);
    }
    freeifaddrs(first);
  }
  if (up) return {"loopback", Verdict::ok, "up"};
  return {"loopback", Verdict::fix, "is down: as root, ip link set lo up"};
}

Finding check_multicast_route() {
  const std::string interface = multicast_interface(content_of("/proc/net/route"));
  if (!interface.empty()) return {"multicast route", Verdict::ok, "through " + interface};
  return {
      "multicast route", Verdict::fix,
      "none, LCM cannot start: as root, launch/multicast-route; or use ./run or launch/netns, which make a "
      "private network"};
}

/// Sends a message to itself: a route alone does not say that multicast comes back.
Finding check_lcm() {
  lcm::LCM lcm(default_lcm_url);
  if (!lcm.good()) {
    return {"LCM", Verdict::fix, fmt::format("can't open {}: see the lines above", default_lcm_url)};
  }
  bool heard = false;
  lcm.subscribeFunction(
      "DOCTOR", +[](const lcm::ReceiveBuffer*, const std::string&, bool* flag) { *flag = true; }, &heard);
  lcm.publish("DOCTOR", "", 0);
  constexpr int patience_ms = 1000;
  lcm.handleTimeout(patience_ms);
  if (heard) return {"LCM", Verdict::ok, fmt::format("a message to itself came back, {}", default_lcm_url)};
  return {"LCM", Verdict::fix,
          fmt::format("a message to itself did not come back ({}): look for a firewall that drops multicast",
                      default_lcm_url)};
}

Finding check_receive_buffer() {
  return judge_receive_buffer(static_cast<long>(granted_receive_buffer(std::numeric_limits<int>::max())));
}

Finding check_shared_memory() {
  const std::string name = "shared memory";
  if (access("/dev/shm", W_OK) != 0) {
    return {name, Verdict::fix, "/dev/shm is not writable: mount a tmpfs there, mode 1777"};
  }
  struct statvfs info {};
  if (statvfs("/dev/shm", &info) != 0) return {name, Verdict::fix, "/dev/shm says nothing of its size"};
  const double free_mb = static_cast<double>(info.f_bavail) * static_cast<double>(info.f_frsize) / 1e6;
  if (free_mb >= needed_shared_memory_mb) {
    return {name, Verdict::ok, fmt::format("/dev/shm is writable, {:.0f} MB free", free_mb)};
  }
  return {
      name, Verdict::fix,
      fmt::format("/dev/shm has {:.0f} MB free, a ring takes up to {:.0f}: remove old files there, or in a "
                  "container start it with --shm-size",
                  free_mb, needed_shared_memory_mb)};
}

/// Nothing: the device is no camera, e.g. the metadata node that comes with one.
std::optional<Finding> check_video_device(const fs::path& device) {
  const FileDescriptor file(open(device.c_str(), O_RDWR | O_NONBLOCK));
  if (file.get() < 0) {
    return Finding{"camera", Verdict::limited,
                   device.string() + " can't be opened: add the user to group video"};
  }
  v4l2_capability capability{};
  if (ioctl(file.get(), VIDIOC_QUERYCAP, &capability) != 0) return std::nullopt;
  if ((capability.device_caps & V4L2_CAP_VIDEO_CAPTURE) == 0) return std::nullopt;
  const auto* const card = reinterpret_cast<const char*>(capability.card);
  return Finding{"camera", Verdict::ok, fmt::format("{}: {}", device.string(), card)};
}

std::vector<Finding> check_cameras() {
  std::vector<fs::path> devices;
  for (const auto& entry : fs::directory_iterator("/dev")) {
    if (entry.path().filename().string().starts_with("video")) devices.push_back(entry.path());
  }
  std::sort(devices.begin(), devices.end());
  std::vector<Finding> findings;
  for (const fs::path& device : devices) {
    if (const auto finding = check_video_device(device)) findings.push_back(*finding);
  }
  if (findings.empty()) {
    findings.push_back({"camera", Verdict::ok, "no camera: fine for files and the simulator"});
  }
  return findings;
}

std::optional<fs::path> first_existing(const std::vector<fs::path>& candidates) {
  for (const fs::path& path : candidates) {
    if (fs::exists(path)) return fs::canonical(path);
  }
  return std::nullopt;
}

std::optional<fs::path> program(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path file = fs::path(folder) / name;
    if (access(file.c_str(), X_OK) == 0 && !fs::is_directory(file)) return file;
  }
  return std::nullopt;
}

Finding check_types_jar() {
  const fs::path bin = fs::canonical("/proc/self/exe").parent_path();
  const auto jar =
      first_existing({bin / "../stevedore_types.jar", bin / "../share/java/stevedore_types.jar"});
  if (jar) return {"message types for Java", Verdict::ok, jar->string()};
  return {"message types for Java", Verdict::limited,
          "no stevedore_types.jar, spy shows no fields: build the target lcmtypes_java"};
}

Finding check_jar(const std::string& name, const std::string& package) {
  const auto jar = first_existing({"/usr/share/java/" + name, "/usr/local/share/java/" + name});
  if (jar) return {name, Verdict::ok, jar->string()};
  return {name, Verdict::limited, "not found, spy does not start: apt-get install " + package};
}

Finding check_java() {
  const auto java = program("java");
  if (!java) return {"Java", Verdict::limited, "no java, spy does not start: apt-get install default-jre"};
  const fs::path home = fs::canonical(*java).parent_path().parent_path();
  if (fs::exists(home / "lib/libawt_xawt.so")) return {"Java", Verdict::ok, home.string()};
  return {"Java", Verdict::limited,
          home.string() + " opens no windows, spy needs them: apt-get install default-jre"};
}

Finding check_libraries() {
  return {
      "libraries", Verdict::ok,
      fmt::format("OpenCV {} (built against {}), LCM {}, Eigen {}.{}.{}", cv::getVersionString(), CV_VERSION,
                  STEVEDORE_LCM_VERSION, EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)};
}

/// What OpenCV reads video with, from the lines "NAME: YES (...)" of its build information.
Finding check_video_support() {
  std::vector<std::string> missing, there;
  const std::string& information = cv::getBuildInformation();
  for (const std::string name : {"FFMPEG", "GStreamer", "v4l/v4l2"}) {
    const auto at = information.find(name + ":");
    const auto end = information.find('\n', at);
    const bool has =
        at != std::string::npos && information.substr(at, end - at).find("YES") != std::string::npos;
    (has ? there : missing).push_back(name);
  }
  const std::string text = fmt::format("OpenCV has {}", fmt::join(there, ", "));
  if (missing.empty()) return {"video", Verdict::ok, text};
  return {"video", Verdict::limited,
          fmt::format("{}, not {}: some files or cameras can't be read; use the distribution's OpenCV", text,
                      fmt::join(missing, ", "))};
}

Finding check_programs(const std::string& what, const std::vector<std::string>& names,
                       const std::string& package) {
  std::vector<std::string> missing;
  for (const std::string& name : names) {
    if (!program(name)) missing.push_back(name);
  }
  if (missing.empty()) return {what, Verdict::ok, fmt::format("{}", fmt::join(names, ", "))};
  return {what, Verdict::fix, fmt::format("no {}: apt-get install {}", fmt::join(missing, ", "), package)};
}

}  // namespace

std::string multicast_interface(const std::string& route_table) {
  std::istringstream lines(route_table);
  std::string line, best;
  std::getline(lines, line);  // the head of the table
  int64_t best_mask = -1;
  while (std::getline(lines, line)) {
    std::istringstream fields(line);
    std::string interface, destination, gateway, flags, use_count, use, metric, mask;
    fields >> interface >> destination >> gateway >> flags >> use_count >> use >> metric >> mask;
    const uint32_t bits = address_of(mask);
    if ((lcm_group & bits) != address_of(destination) || int64_t{bits} <= best_mask) continue;
    best = interface;
    best_mask = bits;
  }
  return best;
}

Finding judge_receive_buffer(long rmem_max_bytes) {
  const std::string name = "receive buffer";
  const std::string cure = fmt::format("sysctl -w net.core.rmem_max={}", wanted_receive_buffer_bytes);
  if (rmem_max_bytes < needed_receive_buffer_bytes) {
    return {
        name, Verdict::limited,
        fmt::format("net.core.rmem_max is {}: frames larger than {} kB are refused inline (shared memory is "
                    "not concerned); as root, {}",
                    rmem_max_bytes, inline_limit_bytes / 1000, cure)};
  }
  if (rmem_max_bytes < wanted_receive_buffer_bytes) {
    return {name, Verdict::ok,
            fmt::format("net.core.rmem_max is {}, the bus asks for {}: it holds {} of the largest inline "
                        "frames, not {}; to raise it, {}",
                        rmem_max_bytes, wanted_receive_buffer_bytes,
                        static_cast<size_t>(rmem_max_bytes) / inline_limit_bytes,
                        wanted_receive_buffer_bytes / inline_limit_bytes, cure)};
  }
  return {name, Verdict::ok,
          fmt::format("net.core.rmem_max is {}, the bus asks for {}", rmem_max_bytes,
                      wanted_receive_buffer_bytes)};
}

std::vector<Finding> all_findings() {
  std::vector<Finding> findings = {check_loopback(), check_multicast_route(), check_lcm(),
                                   check_receive_buffer(), check_shared_memory()};
  const std::vector<Finding> cameras = check_cameras();
  findings.insert(findings.end(), cameras.begin(), cameras.end());
  const std::vector<Finding> rest = {
      check_video_support(),
      check_libraries(),
      check_programs("supervisor", {"runsv", "runsvdir", "sv"}, "runit"),
      check_programs("private network", {"unshare", "nsenter", "setpriv", "ip"}, "util-linux iproute2"),
      check_types_jar(),
      check_java(),
      check_jar("lcm.jar", "liblcm-java"),
      check_jar("jchart2d.jar", "libjchart2d-java")};
  findings.insert(findings.end(), rest.begin(), rest.end());
  return findings;
}

}  // namespace stevedore
