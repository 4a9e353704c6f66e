#include "gimbal_proc/gimbal_stage.hpp"
#include "runtime/camera_file.hpp"
#include "runtime/process.hpp"

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] {
    constexpr int wait_ms = 50;
    stevedore::Process process(
        argc, argv, "gimbal_proc",
        "Keeps the camera level, and says how level it is: GIMBAL_COMMAND, GIMBAL_LEVEL.");
    const auto camera = stevedore::camera_of(process.config());
    stevedore::GimbalStage stage(process.settings<stevedore::GimbalSettings>("gimbal"),
                                 camera ? camera->mount : stevedore::CameraMount{}, process.bus());
    return process.run([&] {
      process.bus().handle(wait_ms);
      return stage.condition();
    });
  });
}
