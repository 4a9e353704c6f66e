#include "tools/calibrate_board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace stevedore {
namespace {

/// A sharp lens and the pixels' own width make 0.5 to 0.8 px. A camera that moves 5 px while it exposes makes
/// 5 / sqrt(12) = 1.4 px, 1.6 together; one that moves so fast also shears the board as its rows are read one
/// after the other. Images of more pixels are given the same angle: 1.6 px at 640 x 480.
constexpr double most_blur_px = 1.6, most_blur_by_diagonal = 0.002;

/// A corner is found in the window about it, half a square each way, that must hold its edges: 2.5 of the
/// blur above.
constexpr double least_square_px = 10;

/// What a board says of the lens grows with the square of its extent: one seven times smaller than the image
/// would be one in fifty, and as many views would be needed.
constexpr double least_area = 1.0 / 50;

/// A view has six unknowns of its own, three corners' worth. The rest is what it says of the camera.
constexpr std::size_t fewest_corners = 8;

/// Of the diagonal, the way of the corner that moved most between two views (24 px at 640 x 480). What bends
/// a lens's image changes over a fifth of it or so, and a tilt by 20 degrees moves a corner of a board half
/// as wide as the image as far; a board held still adds the same error of corners again, not news.
constexpr double least_way = 0.03;

const std::map<std::string, cv::aruco::PREDEFINED_DICTIONARY_NAME> dictionaries = {
    {"4X4_50", cv::aruco::DICT_4X4_50},   {"4X4_100", cv::aruco::DICT_4X4_100},
    {"4X4_250", cv::aruco::DICT_4X4_250}, {"5X5_100", cv::aruco::DICT_5X5_100},
    {"5X5_250", cv::aruco::DICT_5X5_250}, {"6X6_250", cv::aruco::DICT_6X6_250}};

cv::Ptr<cv::aruco::CharucoBoard> charuco(const Board& board) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(dictionaries.at(board.codes));
  return cv::aruco::CharucoBoard::create(board.corners.width + 1, board.corners.height + 1,
                                         static_cast<float>(board.square_m),
                                         static_cast<float>(board.marker_m), dictionary);
}

cv::Mat draw_chessboard(const Board& board, int square_px) {
  const cv::Size squares = board.corners + cv::Size(1, 1);
  cv::Mat image((squares.height + 2) * square_px, (squares.width + 2) * square_px, CV_8U, cv::Scalar(255));
  for (int row = 0; row < squares.height; ++row)
    for (int col = row % 2; col < squares.width; col += 2)
      image(cv::Rect((col + 1) * square_px, (row + 1) * square_px, square_px, square_px)) = 0;
  return image;
}

View find_chessboard(const Board& board, const cv::Mat& grey) {
  View view;
  if (!cv::findChessboardCornersSB(grey, board.corners, view.corners_px, cv::CALIB_CB_NORMALIZE_IMAGE))
    return {};
  for (int id = 0; id < board.corners.area(); ++id) view.ids.push_back(id);
  return view;
}

View find_charuco(const Board& board, const cv::Mat& grey) {
  const auto layout = charuco(board);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> marker_ids;
  cv::aruco::detectMarkers(grey, layout->dictionary, markers, marker_ids);
  View view;
  if (!markers.empty())
    cv::aruco::interpolateCornersCharuco(markers, marker_ids, grey, layout, view.corners_px, view.ids);
  return view;
}

/// Pairs of corners, by their places in `view`, that are neighbours along a row (0) or a column (1).
std::array<std::vector<std::pair<std::size_t, std::size_t>>, 2> edges_of(const Board& board,
                                                                         const View& view) {
  std::map<int, std::size_t> place;
  for (std::size_t i = 0; i < view.ids.size(); ++i) place[view.ids[i]] = i;
  std::array<std::vector<std::pair<std::size_t, std::size_t>>, 2> edges;
  for (const auto& [id, i] : place) {
    const auto right = place.find(id + 1), below = place.find(id + board.corners.width);
    if (right != place.end() && right->first % board.corners.width != 0)
      edges[0].emplace_back(i, right->second);
    if (below != place.end()) edges[1].emplace_back(i, below->second);
  }
  return edges;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double length_px(const View& view, const std::pair<std::size_t, std::size_t>& edge) {
  return cv::norm(view.corners_px[edge.first] - view.corners_px[edge.second]);
}

/// Both finders leave noise that is not in the image, and OpenCV 4.6's for ChArUco half a pixel more: each
/// corner is found once more, in a window that its neighbours and a ChArUco board's markers stay out of, a
/// pixel of blur included. Beyond 5 px the edges of a board at the border of a wide lens bend away from
/// straight lines by 0.07 px and more.
void refine(const Board& board, const cv::Mat& grey, View& view) {
  std::vector<double> nearest(view.ids.size(), HUGE_VAL);
  for (const auto& direction : edges_of(board, view))
    for (const auto& edge : direction)
      for (const std::size_t i : {edge.first, edge.second})
        nearest[i] = std::min(nearest[i], length_px(view, edge));
  const double share = board.kind == Board::Kind::charuco ? (1 - board.marker_m / board.square_m) / 2 : 0.4;
  const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 1e-3);
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    if (!std::isfinite(nearest[i])) continue;
    const int half = std::clamp(static_cast<int>(share * nearest[i]) - 1, 2, 5);
    std::vector<cv::Point2f> corner = {view.corners_px[i]};
    cv::cornerSubPix(grey, corner, {half, half}, {-1, -1}, until);
    view.corners_px[i] = corner[0];
  }
}

/// The middle of an edge laid flat: columns along it, rows across, four samples a pixel.
constexpr int samples_a_pixel = 4;
cv::Mat across_edge(const View& view, const std::pair<std::size_t, std::size_t>& edge, const cv::Mat& grey) {
  const cv::Point2f a = view.corners_px[edge.first], b = view.corners_px[edge.second];
  const cv::Point2f middle = (a + b) / 2, along = (b - a) / cv::norm(b - a), across(-along.y, along.x);
  const double length = cv::norm(b - a);
  // half of the edge, so that neighbouring edges stay out; and as far across
  const int half_long = static_cast<int>(length / 4),
            half_across = static_cast<int>(length * 0.4) * samples_a_pixel;
  cv::Mat map(2 * half_across + 1, 2 * half_long + 1, CV_32FC2), patch;
  for (int row = 0; row < map.rows; ++row)
    for (int col = 0; col < map.cols; ++col)
      map.at<cv::Point2f>(row, col) = middle + along * static_cast<float>(col - half_long) +
                                      across * (static_cast<float>(row - half_across) / samples_a_pixel);
  cv::remap(grey, patch, map, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return patch;
}

/// Standard deviation of the Gaussian whose slope is as steep, over the contrast of its surroundings. Near
/// the edge only: a ChArUco board's markers have edges too, an eighth of a square away.
double edge_blur_px(const cv::Mat& patch) {
  cv::Mat profile;
  cv::reduce(patch, profile, 1, cv::REDUCE_AVG, CV_64F);
  const int middle = profile.rows / 2, reach = std::max(samples_a_pixel, middle / 4);
  double slope = 0;
  for (int row = std::max(middle - reach, 2); row <= std::min(middle + reach, profile.rows - 3); ++row)
    slope = std::max(slope,
                     std::abs(profile.at<double>(row + 2) - profile.at<double>(row - 2)));  // a pixel apart
  double darkest = 0, brightest = 0;
  cv::minMaxLoc(profile, &darkest, &brightest);
  if (slope <= 0) return HUGE_VAL;
  return (brightest - darkest) / (slope * std::sqrt(2 * std::numbers::pi));
}

}  // namespace

cv::Point3f Board::point_m(int id) const {
  const auto square = static_cast<float>(square_m);
  const int col = id % corners.width, row = id / corners.width;
  return {static_cast<float>(col + 1) * square, static_cast<float>(row + 1) * square, 0};
}

std::vector<std::string> code_names() {
  std::vector<std::string> names;
  for (const auto& entry : dictionaries) names.push_back(entry.first);
  return names;
}

std::optional<std::string> fault_of(const Board& board) {
  if (board.kind == Board::Kind::chessboard) return std::nullopt;
  const int needed = (board.corners.width + 1) * (board.corners.height + 1) / 2;
  const int codes = cv::aruco::getPredefinedDictionary(dictionaries.at(board.codes))->bytesList.rows;
  if (needed <= codes) return std::nullopt;
  return fmt::format("{} has {} codes, the board needs {}", board.codes, codes, needed);
}

cv::Mat draw_board(const Board& board, int square_px) {
  if (board.kind == Board::Kind::chessboard) return draw_chessboard(board, square_px);
  cv::Mat image;
  charuco(board)->draw(
      cv::Size((board.corners.width + 3) * square_px, (board.corners.height + 3) * square_px), image,
      square_px);
  return image;
}

std::variant<View, Refusal> look(const Board& board, const cv::Mat& grey, const std::string& name) {
  View view =
      board.kind == Board::Kind::chessboard ? find_chessboard(board, grey) : find_charuco(board, grey);
  view.name = name;
  const std::size_t all = static_cast<std::size_t>(board.corners.area());
  if (view.ids.empty())
    return Refusal{board.kind == Board::Kind::chessboard
                       ? fmt::format("no board of {} x {} inner corners that is wholly in the picture",
                                     board.corners.width, board.corners.height)
                       : "no corner of the board was found"};
  if (view.ids.size() < std::min(fewest_corners, all))
    return Refusal{
        fmt::format("{} of {} corners found, {} are needed", view.ids.size(), all, fewest_corners)};
  const auto edges = edges_of(board, view);
  std::vector<double> lengths;
  for (const auto& direction : edges)
    for (const auto& edge : direction) lengths.push_back(length_px(view, edge));
  if (edges[0].empty() || edges[1].empty()) return Refusal{"corners of one line of the board only"};
  if (const double side = median(lengths); side < least_square_px)
    return Refusal{
        fmt::format("too small: its squares are {:.1f} px wide, {} are needed", side, least_square_px)};
  std::vector<cv::Point2f> hull;
  cv::convexHull(view.corners_px, hull);
  if (const double share = cv::contourArea(hull) / grey.size().area(); share < least_area)
    return Refusal{fmt::format("too small: the corners span {:.1f} % of the picture, {:.0f} % are needed",
                               100 * share, 100 * least_area)};
  refine(board, grey, view);
  const double blur = blur_px(board, view, grey);
  const double most = std::max(most_blur_px, most_blur_by_diagonal * std::hypot(grey.cols, grey.rows));
  if (blur > most)
    return Refusal{
        fmt::format("blurred: edges are spread over {:.1f} px (sigma), at most {:.1f} will do", blur, most)};
  return view;
}

double blur_px(const Board& board, const View& view, const cv::Mat& grey) {
  double most = 0;
  for (const auto& direction : edges_of(board, view)) {
    std::vector<double> blurs;
    for (const auto& edge : direction) blurs.push_back(edge_blur_px(across_edge(view, edge, grey)));
    most = std::max(most, median(blurs));
  }
  return most;
}

std::optional<Refusal> too_similar(const Board& board, const View& view, const std::vector<View>& taken,
                                   const cv::Size& image_px) {
  const double least = least_way * std::hypot(image_px.width, image_px.height);
  std::map<int, cv::Point2f> here;
  for (std::size_t i = 0; i < view.ids.size(); ++i) here[view.ids[i]] = view.corners_px[i];
  const int last = board.corners.area() - 1;
  for (const View& other : taken) {
    for (const bool turned :
         {false, true}) {  // a chessboard is told from itself by half a turn at times only
      double way = 0;
      std::size_t both = 0;
      for (std::size_t i = 0; i < other.ids.size(); ++i) {
        const auto at = here.find(turned ? last - other.ids[i] : other.ids[i]);
        if (at == here.end()) continue;
        way = std::max(way, cv::norm(at->second - other.corners_px[i]));
        ++both;
      }
      // another half of the board is another view
      if (2 * both > std::max(here.size(), other.ids.size()) && way < least)
        return Refusal{
            fmt::format("too similar to {}: no corner moved more than {:.0f} px, {:.0f} are needed",
                        other.name, way, least)};
    }
  }
  return std::nullopt;
}

}  // namespace stevedore
