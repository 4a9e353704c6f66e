#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <opencv2/core/utility.hpp>

int main(int argc, char** argv) {
  cv::setNumThreads(1);  // as every process does
  return Catch::Session().run(argc, argv);
}
