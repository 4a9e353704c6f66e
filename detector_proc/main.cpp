#include "detector_proc/detector_stage.hpp"
#include "runtime/process.hpp"

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] {
    stevedore::Process process(argc, argv, "detector_proc",
                               "Finds every circle and cargo of each FRAME: ELLIPSES.");
    stevedore::DetectorStage stage(process.settings<stevedore::DetectorSettings>("detector"), process.bus(),
                                   process.frames());
    return process.run();
  });
}
