#include "runtime/camera_file.hpp"
#include "runtime/process.hpp"
#include "tracker_proc/tracker_stage.hpp"

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] {
    stevedore::Process process(argc, argv, "tracker_proc",
                               "Follows every ellipse, and the one that matters: TRACKS.");
    stevedore::TrackerStage stage(process.settings<stevedore::TrackerSettings>("tracker"),
                                  stevedore::camera_of(process.config()), process.bus(), process.frames());
    return process.run();
  });
}
