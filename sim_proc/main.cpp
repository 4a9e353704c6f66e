#include "runtime/camera_file.hpp"
#include "runtime/kernel.hpp"
#include "runtime/process.hpp"
#include "sim_proc/sim_stage.hpp"

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] {
    constexpr int wait_ms = 2;  // less than half a step of the world
    stevedore::Process process(
        argc, argv, "sim_proc",
        "The world, in place of camera, aircraft and sensors: FRAME, VEHICLE_STATE, ...");
    const auto camera = stevedore::camera_of(process.config());
    if (!camera)
      throw stevedore::ConfigError("sim_proc needs a camera: camera_file, as in config/world.yaml");
    stevedore::SimStage stage(process.settings<stevedore::SimSettings>("sim"), *camera,
                              stevedore::name_in_this_network("sim", process.bus().url()), process.bus());
    return process.run([&] {
      process.bus().handle(wait_ms);
      return stage.work(process.bus().now_utime());
    });
  });
}
