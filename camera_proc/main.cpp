#include "camera_proc/camera_stage.hpp"
#include "runtime/camera_file.hpp"
#include "runtime/kernel.hpp"
#include "runtime/process.hpp"

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] {
    stevedore::Process process(argc, argv, "camera_proc", "Camera, video or image files: FRAME.");
    stevedore::CameraStage stage(
        process.settings<stevedore::CameraSettings>("camera"), stevedore::camera_of(process.config()),
        stevedore::name_in_this_network("camera", process.bus().url()), process.bus());
    return process.run([&stage] { return stage.work(); });
  });
}
