#include "tools/campaign_workers.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <thread>

#include "runtime/command_line.hpp"
#include "runtime/file_descriptor.hpp"

namespace stevedore {
namespace {

using Clock = std::chrono::steady_clock;

[[noreturn]] void fail(const char* what) {
  throw std::runtime_error(fmt::format("{}: {}", what, std::strerror(errno)));
}

/// What a worker writes: memory, so that nobody has to read while it runs.
int memory_file(const char* name) {
  const int file = memfd_create(name, MFD_CLOEXEC);
  if (file < 0) fail("no memory for what a worker says");
  return file;
}

std::string content_of(const FileDescriptor& file) {
  std::string text;
  std::array<char, 4096> part{};
  for (ssize_t count = -1; count != 0;) {
    count =
        std::max<ssize_t>(0, pread(file.get(), part.data(), part.size(), static_cast<off_t>(text.size())));
    text.append(part.data(), static_cast<std::size_t>(count));
  }
  return text;
}

std::string last_line_of(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const auto end = text.rfind('\n');
  return end == std::string::npos ? text : text.substr(end + 1);
}

/// In the child.
[[noreturn]] void become(std::vector<std::string> arguments, int out, int err, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);  // it has ended already
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  execv("/proc/self/exe", argv.data());  // the program that runs, also where its file was replaced
  _exit(127);
}

class Worker {
 public:
  Worker(std::int64_t seed, const std::vector<std::string>& arguments)
      : seed_(seed), out_(memory_file("out")), err_(memory_file("err")) {
    std::vector<std::string> all{"campaign"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const pid_t parent = getpid();
    pid_ = fork();
    if (pid_ < 0) fail("no process for a worker");
    if (pid_ == 0) become(std::move(all), out_.get(), err_.get(), parent);
  }
  ~Worker() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  [[nodiscard]] bool has_ended() {
    if (pid_ > 0 && waitpid(pid_, &status_, WNOHANG) == pid_) pid_ = 0;
    return pid_ == 0;
  }
  [[nodiscard]] WorkerEnd end() const {
    return {seed_, content_of(out_), fault(), is_usage_error(),
            std::chrono::duration<double>(Clock::now() - start_).count()};
  }

 private:
  [[nodiscard]] std::string fault() const {
    const std::string words = last_line_of(content_of(err_));
    const std::string particulars = words.empty() ? "" : " (" + words + ")";
    if (WIFSIGNALED(status_))
      return fmt::format("worker ended by signal {}, {}{}", WTERMSIG(status_), strsignal(WTERMSIG(status_)),
                         particulars);
    if (WEXITSTATUS(status_) != 0)
      return fmt::format("worker ended with status {}{}", WEXITSTATUS(status_), particulars);
    return {};
  }

  [[nodiscard]] bool is_usage_error() const {
    return WIFEXITED(status_) && WEXITSTATUS(status_) == exit_usage;
  }

  std::int64_t seed_;
  FileDescriptor out_, err_;
  Clock::time_point start_ = Clock::now();
  pid_t pid_ = 0;  ///< 0: it has ended
  int status_ = 0;
};

}  // namespace

void run_workers(const WorkerOrders& orders) {
  constexpr auto a_look = std::chrono::milliseconds(20);  // of missions that take a minute
  std::vector<std::unique_ptr<Worker>> workers;
  for (std::size_t next = 0; !orders.stops();) {
    while (next < orders.seeds.size() && workers.size() < static_cast<std::size_t>(orders.jobs)) {
      const std::int64_t seed = orders.seeds[next++];
      workers.push_back(std::make_unique<Worker>(seed, orders.arguments(seed)));
    }
    if (workers.empty()) return;
    std::this_thread::sleep_for(a_look);
    std::erase_if(workers, [&](const std::unique_ptr<Worker>& worker) {
      if (!worker->has_ended()) return false;
      if (!orders.stops()) orders.ended(worker->end());
      return true;
    });
  }
}

}  // namespace stevedore
