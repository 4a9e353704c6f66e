#include <spdlog/spdlog.h>

#include "pose_proc/pose_stage.hpp"
#include "runtime/camera_file.hpp"
#include "runtime/process.hpp"

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] {
    stevedore::Process process(
        argc, argv, "pose_proc",
        "Where every circle and cargo is, in metres, and how the platforms move: POSES, PLATFORM_ESTIMATE.");
    const auto camera = stevedore::camera_of(process.config());
    if (!camera) spdlog::warn("no camera_file in the configuration: marks are passed on without poses");
    stevedore::PoseStage stage(process.settings<stevedore::PoseSettings>("pose"), camera, process.bus(),
                               process.settings<stevedore::PlatformSettings>("platform"));
    return process.run();
  });
}
