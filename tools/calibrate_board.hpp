// A calibration board: a chessboard, or a ChArUco board, of which a part may be out of the picture. Its
// corners in an image, and why an image is not good enough.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace stevedore {

struct Board {
  enum class Kind { chessboard, charuco };
  Kind kind = Kind::chessboard;
  cv::Size corners{9, 6};        ///< inner ones: a square less than there are squares, each way
  double square_m = 0.03;        ///< side of a square
  double marker_m = 0.022;       ///< ChArUco: side of a marker
  std::string codes = "4X4_50";  ///< ChArUco: name of OpenCV's dictionary

  /// Corner `id` on the board, z = 0; ids go row by row.
  [[nodiscard]] cv::Point3f point_m(int id) const;
};

/// Names of the dictionaries that Board::codes may have.
std::vector<std::string> code_names();

/// Why there can't be such a board: its dictionary has too few codes.
std::optional<std::string> fault_of(const Board& board);

/// The board with a white margin of a square, `square_px` a square.
cv::Mat draw_board(const Board& board, int square_px);

/// One image of the board.
struct View {
  std::string name;
  std::vector<int> ids;
  std::vector<cv::Point2f> corners_px;  ///< of these ids, pixel (0, 0) the centre of the upper-left one
};

/// Why an image is not used, in words.
struct Refusal {
  std::string why;
};

/// The board's corners to sub-pixel; refused if it is not found, blurred, or small. `grey` has 8 bits.
std::variant<View, Refusal> look(const Board& board, const cv::Mat& grey, const std::string& name);

/// Standard deviation of the blur across the board's edges, of the direction in which they are blurred more:
/// a moved camera blurs in one.
double blur_px(const Board& board, const View& view, const cv::Mat& grey);

/// Why this view says nothing that one of `taken` does not say; nothing if it does.
std::optional<Refusal> too_similar(const Board& board, const View& view, const std::vector<View>& taken,
                                   const cv::Size& image_px);

}  // namespace stevedore
