// `calibrate` on pictures of a board through lenses that are known.
#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <opencv2/imgcodecs.hpp>

#include "runtime/camera_file.hpp"
#include "tests/support/board_film.hpp"
#include "tests/support/program.hpp"
#include "tools/calibrate_coverage.hpp"
#include "tools/calibrate_output.hpp"
#include "tools/camera_yaml.hpp"

using namespace stevedore;

namespace {

constexpr double noise_levels = 4;
const cv::Size image_px = example_px;

Board board_of(Board::Kind kind) {
  Board board;
  board.kind = kind;
  return board;
}

const Board chessboard = board_of(Board::Kind::chessboard);
const CameraModel wide = example_lens(Distortion::plumb_bob);

/// The board straight before the camera, so far that a square is so wide.
BoardPose straight(double square_px, const Eigen::Vector3d& degrees = Eigen::Vector3d::Zero(),
                   const Eigen::Vector2d& aside_px = Eigen::Vector2d::Zero()) {
  const double z_m = wide.given.fx_px * chessboard.square_m / square_px;
  return board_pose(chessboard, degrees,
                    {aside_px.x() * z_m / wide.given.fx_px, aside_px.y() * z_m / wide.given.fy_px, z_m});
}

std::vector<View> true_views(const std::vector<BoardPose>& poses, const CameraModel& camera, double noise_px,
                             std::mt19937& dice) {
  std::vector<View> views;
  for (const BoardPose& pose : poses) {
    views.push_back(true_view(chessboard, camera, pose, noise_px, dice));
    views.back().name = "view " + std::to_string(views.size());
  }
  return views;
}

std::vector<View> true_views(double noise_px = 0.05) {
  std::mt19937 dice(5);
  return true_views(good_poses(chessboard, wide, 5), wide, noise_px, dice);
}

std::string refusal(const cv::Mat& image, const Board& board = chessboard) {
  const auto seen = look(board, image, "image");
  const auto* refused = std::get_if<Refusal>(&seen);
  return refused ? refused->why : "none";
}

double nees(const Fit& fit, const CameraModel& truth) {
  const Eigen::VectorXd error = parameters(fit.camera) - parameters(truth);
  return error.dot(fit.covariance.ldlt().solve(error));
}

bool has(const std::vector<std::string>& lines, const std::string& text) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(text) != std::string::npos; });
}

CameraModel with_focal(double factor) {
  CameraModel camera = wide;
  camera.given.fx_px *= factor;
  camera.given.fy_px *= factor;
  camera.rectified = camera.given;
  return camera;
}

}  // namespace

TEST_CASE("rendered boards give the lens back, within what the covariance says") {
  const auto board = board_of(GENERATE(Board::Kind::chessboard, Board::Kind::charuco));
  const CameraModel camera = example_lens(GENERATE(Distortion::plumb_bob, Distortion::equidistant));
  const BoardFilm film(board, camera);
  std::vector<View> views;
  unsigned number = 0;
  for (const BoardPose& pose : good_poses(board, camera, 3)) {
    auto seen = look(board, film.take(pose, noise_levels, number), "view " + std::to_string(number));
    ++number;
    if (auto* view = std::get_if<View>(&seen)) views.push_back(*view);
  }
  CHECK(views.size() + 2 >= number);
  std::vector<RefusedView> refused;
  const Fit fit = fit_without_outliers(board, views, image_px, camera.distortion, refused);
  CHECK(refused.empty());
  // noise of 4 levels at a contrast of 170: chessboard 0.05 px, ChArUco in its smaller windows 0.1
  CHECK(fit.rms_px < 0.12);
  const Eigen::VectorXd error = parameters(fit.camera) - parameters(camera);
  const auto names = parameter_names(camera);
  for (Eigen::Index k = 0; k < error.size(); ++k) {
    INFO(names[static_cast<std::size_t>(k)] << " off by " << error[k]);
    CHECK(std::abs(error[k]) < 4 * std::sqrt(fit.covariance(k, k)));
  }
  CHECK(nees(fit, camera) < 33.7);  // chi squared of nine, once in ten thousand
  CHECK(std::sqrt(fit.covariance(0, 0)) < 0.001 * camera.given.fx_px);
  CHECK(missing_views(views, &fit, image_px).empty());
}

TEST_CASE("the covariance is as large as the errors, over many sets with known noise") {
  const CameraModel camera = example_lens(GENERATE(Distortion::plumb_bob, Distortion::equidistant));
  const auto poses = good_poses(chessboard, camera, 1);
  std::mt19937 dice(7);
  constexpr int sets = 60;
  double sum = 0;
  for (int i = 0; i < sets; ++i) {
    const Fit made = fit(chessboard, true_views(poses, camera, 0.1, dice), image_px, camera.distortion);
    sum += nees(made, camera) / static_cast<double>(parameters(camera).size());
    CHECK(made.rms_px == Approx(0.1 * std::sqrt(2)).epsilon(0.1));
  }
  // the mean of 60 x 8 squares of normal numbers has a sigma of 6.5 %
  CHECK(sum / sets > 0.8);
  CHECK(sum / sets < 1.2);
}

TEST_CASE("poor images are refused, with the reason") {
  const BoardFilm film(chessboard, wide);
  CHECK(refusal(film.take(straight(30), noise_levels, 1)) == "none");
  CHECK_THAT(refusal(cv::Mat(image_px, CV_8U, cv::Scalar(90))), Catch::StartsWith("no board of 9 x 6"));
  // a third of it out of the picture
  CHECK_THAT(refusal(film.take(straight(40, {0, 0, 0}, {450, 0}), noise_levels, 1)),
             Catch::StartsWith("no board"));
  CHECK_THAT(refusal(film.take(straight(30), noise_levels, 1, 2.0)), Catch::StartsWith("blurred"));
  CHECK_THAT(refusal(film.take(straight(30), noise_levels, 1, 0.6, 9)),
             Catch::StartsWith("blurred"));  // in one direction
  CHECK(refusal(film.take(straight(30), noise_levels, 1, 0.6, 3)) == "none");
  CHECK_THAT(refusal(film.take(straight(9), noise_levels, 1, 0.4)), Catch::StartsWith("too small"));
  CHECK_THAT(refusal(film.take(straight(11.5), noise_levels, 1, 0.4)), Catch::Contains("% of the picture"));
}

TEST_CASE("the blur is measured in pixels") {
  const BoardFilm film(chessboard, wide);
  for (const double lens_px : {0.5, 1.0, 1.4}) {
    const cv::Mat image = film.take(straight(30, {0, 0, 20}), noise_levels, 1, lens_px);
    const auto seen = look(chessboard, image, "image");
    REQUIRE(std::holds_alternative<View>(seen));
    // the pixel's own width adds 1 / sqrt(12) twice: it is integrated over, and interpolated between
    CHECK(blur_px(chessboard, std::get<View>(seen), image) == Approx(std::hypot(lens_px, 0.5)).margin(0.15));
  }
}

TEST_CASE("a ChArUco board may be partly out of the picture") {
  const Board board = board_of(Board::Kind::charuco);
  const BoardFilm film(board, wide);
  const auto seen = look(board, film.take(straight(40, {0, 0, 0}, {450, 0}), noise_levels, 1), "image");
  REQUIRE(std::holds_alternative<View>(seen));
  const View& view = std::get<View>(seen);
  CHECK(view.ids.size() > 8);
  CHECK(view.ids.size() < 54);
  CHECK_THAT(refusal(cv::Mat(image_px, CV_8U, cv::Scalar(90)), board), Catch::StartsWith("no corner"));
  CHECK_THAT(refusal(film.take(straight(40, {0, 0, 0}, {700, 0}), noise_levels, 1), board),
             !Catch::Equals("none"));
}

TEST_CASE("a view like one that is there already is refused") {
  std::mt19937 dice(1);
  const auto view = [&](const BoardPose& pose) { return true_view(chessboard, wide, pose, 0.05, dice); };
  const std::vector<View> taken = {view(straight(30))};
  CHECK(too_similar(chessboard, view(straight(30, {0, 0, 0}, {10, 0})), taken, image_px));
  CHECK_FALSE(too_similar(chessboard, view(straight(30, {0, 0, 0}, {30, 0})), taken, image_px));
  CHECK_FALSE(too_similar(chessboard, view(straight(30, {0, 35, 0})), taken, image_px));
  View turned = taken[0];  // as the finder may see a chessboard
  std::reverse(turned.corners_px.begin(), turned.corners_px.end());
  CHECK(too_similar(chessboard, turned, taken, image_px));
}

TEST_CASE("a view whose residual sticks out is refused after the fit") {
  auto views = true_views();
  for (std::size_t i = 0; i < views[4].ids.size(); ++i)  // bent by a pixel and a half
    views[4].corners_px[i].y += 1.5F * std::sin(static_cast<float>(views[4].ids[i] % 9) / 8 * 3.14F);
  std::vector<RefusedView> refused;
  const Fit fit = fit_without_outliers(chessboard, views, image_px, Distortion::plumb_bob, refused);
  REQUIRE(refused.size() == 1);
  CHECK(refused[0].name == "view 5");
  CHECK_THAT(refused[0].refusal.why, Catch::Contains("residual"));
  CHECK(fit.views.size() == views.size() - 1);
  CHECK(fit.rms_px < 0.08);
}

TEST_CASE("too few views are no calibration") {
  auto views = true_views();
  views.resize(fewest_views - 1);
  CHECK_THROWS_WITH(fit(chessboard, views, image_px, Distortion::plumb_bob), Catch::Contains("at least 8"));
}

TEST_CASE("boards that all face the camera leave the focal length open, and it is said") {
  std::mt19937 dice(4);
  std::vector<BoardPose> poses;
  for (const double u_px : {-90, -30, 30, 90})
    for (const double v_px : {-60, 0, 60}) poses.push_back(straight(22, {0, 0, 0}, {u_px, v_px}));
  const Fit tilted = fit(chessboard, true_views(), image_px, Distortion::plumb_bob);
  try {
    const Fit flat = fit(chessboard, true_views(poses, wide, 0.05, dice), image_px, Distortion::plumb_bob);
    CHECK(flat.covariance(0, 0) > 400 * tilted.covariance(0, 0));
    CHECK(has(missing_views({}, &flat, image_px), "nothing tilted"));
  } catch (const std::runtime_error& error) {
    CHECK_THAT(error.what(), Catch::Contains("tilted"));
  }
}

TEST_CASE("what is missing is said in words") {
  const auto views = true_views();
  const Fit all = fit(chessboard, views, image_px, Distortion::plumb_bob);
  CHECK(missing_views(views, &all, image_px).empty());

  std::vector<View> without;  // nothing in the lower left corner
  const cv::Rect2d corner = regions(image_px)[6].area_px;
  for (const View& v : views)
    if (std::none_of(v.corners_px.begin(), v.corners_px.end(),
                     [&](const auto& p) { return corner.contains(p); }))
      without.push_back(v);
  const auto missing = missing_views(without, nullptr, image_px);
  REQUIRE(missing.size() == 1);
  CHECK(missing[0] == "no board in the lower left corner");

  std::mt19937 dice(2);
  const auto small = missing_views({true_view(chessboard, wide, straight(20), 0, dice)}, nullptr, image_px);
  CHECK(small.size() == 10);
  CHECK(has(small, "1 of at least 8 views"));
  CHECK(has(small, "no board at the upper edge"));
  CHECK(has(small, "only one board in the middle"));
}

TEST_CASE("tilts are told apart by their side") {
  Fit made = fit(chessboard, true_views(), image_px, Distortion::plumb_bob);
  const struct {
    Eigen::Vector3d degrees;
    const char* words;
  } tilts[] = {{{0, -30, 0}, "to the right"},
               {{0, 30, 0}, "to the left"},
               {{30, 0, 0}, "forwards"},
               {{-30, 0, 0}, "backwards"}};
  for (const auto& tilt : tilts) {
    INFO(tilt.words);
    const BoardPose pose = straight(20, tilt.degrees);
    // by the distance of its sides, not by the sign of an angle
    const auto depth = [&](double x, double y) { return (pose.turn * Eigen::Vector3d(x, y, 0)).z(); };
    const std::string words = tilt.words;
    if (words == "to the right") CHECK(depth(1, 0) > 0.4);
    if (words == "to the left") CHECK(depth(-1, 0) > 0.4);
    if (words == "forwards") CHECK(depth(0, 1) > 0.4);
    if (words == "backwards") CHECK(depth(0, -1) > 0.4);
    made.views.resize(1);
    made.views[0].normal = -pose.turn.col(2);
    const auto missing = missing_views({}, &made, image_px);
    CHECK_FALSE(has(missing, words));
    CHECK(missing.size() == 1 + 9 + 3);
  }
}

TEST_CASE("a file is held against new images") {
  const auto views = true_views();
  const Check right = check(chessboard, views, wide);
  CHECK(right.fits());
  CHECK(right.as_it_is.rms_px == Approx(0.07).epsilon(0.1));
  const Check wrong = check(chessboard, views, with_focal(1.01));
  CHECK_FALSE(wrong.fits());
  CHECK(wrong.better[0] == Approx(wide.given.fx_px).epsilon(0.002));
  CHECK(check(chessboard, {views[0]}, wide).fits());
  CHECK(check(chessboard, {views[4]}, wide).fits());
  CHECK_FALSE(check(chessboard, views, example_lens(Distortion::equidistant)).fits());
  CameraModel straight_lens = wide;
  straight_lens.distortion = Distortion::none;
  straight_lens.coefficients.clear();
  CHECK_FALSE(check(chessboard, views, straight_lens).fits());
}

TEST_CASE("the program: a folder of images becomes a camera file, which fits them, and another does not") {
  const Folder folder;
  const BoardFilm film(chessboard, wide);
  std::filesystem::create_directory(folder.file("images"));
  unsigned number = 0;
  for (const BoardPose& pose : good_poses(chessboard, wide, 3)) {
    cv::imwrite(folder.file("images/" + std::to_string(number) + ".png"),
                film.take(pose, noise_levels, number));
    ++number;
  }
  cv::imwrite(folder.file("images/again.png"),
              film.take(good_poses(chessboard, wide, 3)[0], noise_levels, 90));
  cv::imwrite(folder.file("images/blurred.png"), film.take(straight(30), noise_levels, 91, 2.0));

  std::ofstream(folder.file("images/damaged.png")) << "no image";

  const std::string images = " " + folder.file("images");
  const auto made = run_program("$BIN/calibrate --out " + folder.file("mine.yaml") + images);
  INFO(made.out << made.err);
  REQUIRE(made.status == 0);
  CHECK(made.err.empty());
  CHECK_THAT(made.out, Catch::Contains("again.png: refused: too similar to"));
  CHECK_THAT(made.out, Catch::Contains("blurred.png: refused: blurred"));
  CHECK_THAT(made.out, Catch::Contains("damaged.png: refused: "));
  CHECK_THAT(made.out, !Catch::Contains("missing"));
  const CameraFile file = load_camera_file(folder.file("mine.yaml"));
  CHECK(file.warnings.empty());
  CHECK(file.camera.given.fx_px == Approx(wide.given.fx_px).epsilon(0.001));
  const std::string text = text_of(folder.file("mine.yaml"));
  for (const char* key : {"date: 20", "views: ", "rms_px: 0.0", "sigma: {fx: ", "covariance:"})
    CHECK_THAT(text, Catch::Contains(key));
  const cv::Mat picture = cv::imread(folder.file("mine.png"));
  CHECK(picture.cols == 1280);

  const auto fits = run_program("$BIN/calibrate --check " + folder.file("mine.yaml") + images);
  CHECK(fits.status == 0);
  CHECK_THAT(fits.out, Catch::Contains("0.png: 0.0"));
  CHECK_THAT(fits.out, Catch::EndsWith("mine.yaml: fits\n"));
  std::ofstream(folder.file("wrong.yaml")) << camera_yaml(with_focal(1.01), "wrong");
  const auto wrong = run_program("$BIN/calibrate --check " + folder.file("wrong.yaml") + images);
  CHECK(wrong.status == 1);
  CHECK_THAT(wrong.out, Catch::EndsWith("wrong.yaml: does not fit\n"));
  CHECK_THAT(wrong.out, Catch::Contains("fx     305.02 in the file,     30"));

  cv::imwrite(folder.file("frontal.png"), film.take(straight(22), noise_levels, 92));
  const auto frontal =
      run_program("$BIN/calibrate --check " + folder.file("mine.yaml") + " " + folder.file("frontal.png"));
  INFO(frontal.out);
  CHECK(frontal.status == 1);
  CHECK_THAT(frontal.out, Catch::Contains("missing: nothing tilted") && !Catch::Contains(": fits"));
  CHECK_THAT(frontal.out, Catch::Contains("mine.yaml: not known: "));

  const auto one = run_program("$BIN/calibrate --out " + folder.file("one.yaml") + images + "/2.png");
  CHECK(one.status == 1);
  CHECK_THAT(one.out, Catch::Contains("missing: no board"));
  CHECK_FALSE(std::filesystem::exists(folder.file("one.yaml")));
}

TEST_CASE("the program refuses what makes no sense, and prints boards") {
  const Folder folder;
  for (const char* mistake : {"", "--corners 9 x", "--corners 2x2 x", "--board charuco --marker 0.04 x",
                              "--board charuco --corners 15x11 x", "--camera /dev/video0 x"}) {
    INFO(mistake);
    CHECK(run_program(std::string("$BIN/calibrate ") + mistake).status == 2);
  }
  CHECK(run_program("$BIN/calibrate /nonexistent/*.png").status == 1);
  CHECK(run_program("$BIN/calibrate --board charuco --print " + folder.file("board.png")).status == 0);
  CHECK(cv::imread(folder.file("board.png")).cols == 12 * 300);
}
