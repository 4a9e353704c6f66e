#include <optional>

#include "mission_proc/mission_stage.hpp"
#include "runtime/journal_file.hpp"
#include "runtime/process.hpp"

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] {
    stevedore::Process process(argc, argv, "mission_proc",
                               "Decides what to follow and says what is wrong: MISSION.");
    const auto settings = process.settings<stevedore::MissionSettings>("mission");
    std::optional<stevedore::JournalFile> journal;
    if (!settings.journal.empty()) journal.emplace(settings.journal);
    stevedore::MissionStage stage(settings, process.bus(), journal ? journal->newest() : std::nullopt,
                                  [&](const stevedore::mission_journal_t& line) {
                                    if (journal) journal->keep(line);
                                  });
    process.watch_silence(stevedore::channels::vehicle_state, settings.vehicle_silent_s);
    return process.run();
  });
}
