#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <optional>

#include "mission_proc/mission_stage.hpp"
#include "runtime/journal_file.hpp"
#include "runtime/process.hpp"

namespace {

/// A journal that can't be written, on a full disk say, ends no flight: it is told, and tried again with the
/// next line.
class Journal {
 public:
  explicit Journal(const std::string& path) {
    if (!path.empty()) file_.emplace(path);
  }
  [[nodiscard]] std::optional<stevedore::mission_journal_t> newest() const {
    return file_ ? file_->newest() : std::nullopt;
  }
  void keep(const stevedore::mission_journal_t& line) {
    if (!file_) return;
    try {
      file_->keep(line);
      failure_.clear();
    } catch (const std::runtime_error& error) {
      failure_ = fmt::format("a restart would not know of this flight: {}", error.what());
      spdlog::error("{}", failure_);
    }
  }
  [[nodiscard]] stevedore::Condition condition() const {
    if (failure_.empty()) return {stevedore::health_t::STATE_OK, ""};
    return {stevedore::health_t::STATE_DEGRADED, failure_};
  }

 private:
  std::optional<stevedore::JournalFile> file_;
  std::string failure_;
};

}  // namespace

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] {
    stevedore::Process process(argc, argv, "mission_proc",
                               "Decides what to follow and says what is wrong: MISSION.");
    const auto settings = process.settings<stevedore::MissionSettings>("mission");
    Journal journal(settings.journal);
    stevedore::MissionStage stage(
        settings, process.bus(), journal.newest(),
        [&journal](const stevedore::mission_journal_t& line) { journal.keep(line); });
    process.watch_silence(stevedore::channels::vehicle_state, settings.vehicle_silent_s);
    return process.run([&] {
      process.bus().handle(50);
      return journal.condition();
    });
  });
}
