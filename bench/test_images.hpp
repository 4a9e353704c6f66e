// Image folders for the benches, and what the world does to images.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace stevedore {

struct ImageFolder {
  std::string name;
  std::vector<cv::Mat> images;  ///< BGR
};

/// Every readable image below a folder, in the order of their paths, as a camera would give them: BGR.
ImageFolder load_folder(const std::string& path);

}  // namespace stevedore
