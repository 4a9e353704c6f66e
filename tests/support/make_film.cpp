// make_film DIR FRAMES [SCALE]: the test film as PPM files, frame-0000.ppm and on, enlarged SCALE times.
#include <cstdio>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "tests/support/film.hpp"

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: make_film DIR FRAMES [SCALE]\n");
    return 2;
  }
  const int scale = argc > 3 ? std::atoi(argv[3]) : 1;
  for (int k = 0; k < std::atoi(argv[2]); ++k) {
    char name[32];
    std::snprintf(name, sizeof name, "/frame-%04d.ppm", k);
    cv::Mat image = stevedore::film_frame(k).image;
    if (scale != 1) cv::resize(image, image, {}, scale, scale, cv::INTER_LINEAR);
    if (!cv::imwrite(std::string(argv[1]) + name, image)) return 1;
  }
  return 0;
}
