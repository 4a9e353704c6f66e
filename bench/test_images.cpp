#include "bench/test_images.hpp"

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

namespace stevedore {

namespace fs = std::filesystem;

ImageFolder load_folder(const std::string& path) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (entry.is_regular_file() && cv::haveImageReader(entry.path().string())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  ImageFolder folder{fs::path(path).lexically_normal().filename().string(), {}};
  if (folder.name.empty()) folder.name = path;
  for (const fs::path& file : files) {
    cv::Mat image = cv::imread(file.string(), cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
    if (!image.empty()) folder.images.push_back(std::move(image));
  }
  return folder;
}

}  // namespace stevedore
