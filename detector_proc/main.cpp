#include "detector_proc/detector_stage.hpp"
#include "runtime/camera_file.hpp"
#include "runtime/process.hpp"

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] {
    stevedore::Process process(argc, argv, "detector_proc",
                               "Finds every circle and cargo of each FRAME: ELLIPSES.");
    stevedore::DetectorStage stage(process.settings<stevedore::DetectorSettings>("detector"),
                                   stevedore::camera_of(process.config()), process.bus(), process.frames());
    return process.run();
  });
}
