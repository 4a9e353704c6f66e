// The work of `calibrate`: frames in, words on standard output, files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/calibrate_board.hpp"

namespace stevedore {

struct CalibrateOptions {
  std::vector<std::string> images;                   ///< folders, files, patterns
  std::string video, camera;                         ///< a file; a device or a GStreamer pipeline
  std::string kind = "chessboard", corners = "9x6";  ///< of the board
  Board board;                                       ///< the rest of it
  std::string lens = "plumb_bob";
  std::string out = "camera.yaml";
  std::string check;  ///< a camera file: held against the frames, nothing is written
  std::string print;  ///< the board as an image for the printer, nothing else is done
};

/// The program's exit status.
int calibrate(CalibrateOptions options);

}  // namespace stevedore
