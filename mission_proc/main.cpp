#include "mission_proc/mission_stage.hpp"
#include "runtime/process.hpp"

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] {
    stevedore::Process process(argc, argv, "mission_proc",
                               "Decides what to follow and says what is wrong: MISSION.");
    const auto settings = process.settings<stevedore::MissionSettings>("mission");
    stevedore::MissionStage stage(settings, process.bus());
    process.watch_silence(stevedore::channels::vehicle_state, settings.vehicle_silent_s);
    return process.run();
  });
}
