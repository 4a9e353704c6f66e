#include "tracker_proc/tracker.hpp"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using namespace stevedore;

namespace {

constexpr double kFrame_s = 1.0 / 30;
const cv::Mat kNoImage;

Detection circle(double u, double v, double radius = 20, Label label = Label::circle) {
  Detection d;
  d.outer.ellipse = {u, v, radius, radius, 0};
  d.label = label;
  return d;
}

const Track& track_of(const TrackerResult& result, int detection_index) {
  for (const Track& track : result.tracks)
    if (track.detection_index == detection_index) return track;
  FAIL("no track has detection " << detection_index);
  return result.tracks.front();
}

bool mentions(const std::string& sentence, const std::string& words) {
  return sentence.find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("every ellipse has an id that lasts, velocities are those of the image") {
  Tracker tracker{TrackerSettings{}};
  TrackerResult result;
  for (int k = 0; k < 30; ++k)
    result = tracker.step(k * kFrame_s, kNoImage, {circle(100 + 3 * k, 100), circle(400, 300 - 2 * k)});
  REQUIRE(result.tracks.size() == 2);
  CHECK(track_of(result, 0).id == 1);
  CHECK(track_of(result, 1).id == 2);
  CHECK(track_of(result, 0).velocity_pxps.x() == Approx(90).margin(3));
  CHECK(track_of(result, 0).velocity_pxps.y() == Approx(0).margin(3));
  CHECK(track_of(result, 1).velocity_pxps.y() == Approx(-60).margin(3));
  CHECK(track_of(result, 0).age_frames == 29);
  CHECK(track_of(result, 0).status == TrackStatus::tracking);
  CHECK(result.target.status == TrackStatus::searching);
  CHECK_FALSE(result.target.id);
}

TEST_CASE("ids survive ellipses that cross each other, in whatever order they are listed") {
  Tracker tracker{TrackerSettings{}};
  for (int k = 0; k <= 100; ++k) {
    const Detection right = circle(100 + 2 * k, 200), left = circle(300 - 2 * k, 205);
    const bool swap = k % 3 == 0;
    const auto result =
        tracker.step(k * kFrame_s, kNoImage, swap ? std::vector{left, right} : std::vector{right, left});
    REQUIRE(result.tracks.size() == 2);
    CHECK(track_of(result, swap ? 1 : 0).id == (k == 0 ? track_of(result, 1).id : 2));
    CHECK(track_of(result, swap ? 0 : 1).id == 1);
  }
}

TEST_CASE("a cargo whose rim and foot are found by turns is one track, a circle below it another") {
  Tracker tracker{TrackerSettings{}};
  const Detection below = circle(320, 240, 60), rim = circle(320, 240, 20, Label::cargo),
                  foot = circle(320, 230, 15, Label::unknown);
  TrackerResult result;
  for (int k = 0; k < 60; ++k)
    result = tracker.step(k * kFrame_s, kNoImage, {below, k / 5 % 2 == 0 ? rim : foot});
  REQUIRE(result.tracks.size() == 2);
  CHECK(track_of(result, 0).id == 1);
  CHECK(track_of(result, 1).id == 2);
  CHECK(track_of(result, 1).age_frames == 59);

  // the target keeps its id, though the other one is older
  result = tracker.step(60 * kFrame_s, kNoImage, {below, rim, foot});
  const std::int64_t target = track_of(result, 1).id;
  REQUIRE(target > 2);
  tracker.follow_id(target);
  result = tracker.step(61 * kFrame_s, kNoImage, {below, rim, foot});
  for (int k = 62; k < 70; ++k) result = tracker.step(k * kFrame_s, kNoImage, {below, foot});
  CHECK(result.target.id == target);
  CHECK(track_of(result, 1).id == target);
}

TEST_CASE("one that comes back within its memory keeps its id, one that comes later gets a new one") {
  const double gap_s = GENERATE(0.5, 1.9, 2.2);
  Tracker tracker{TrackerSettings{}};
  double t = 0;
  const auto u = [&] { return 100 + 60 * t; };
  for (; t < 0.5; t += kFrame_s) tracker.step(t, kNoImage, {circle(u(), 100)});
  const double last_seen_s = t - kFrame_s;
  bool reported_lost = false;
  for (; t < last_seen_s + gap_s - 1e-9; t += kFrame_s) {
    const auto result = tracker.step(t, kNoImage, {});
    if (result.tracks.empty()) continue;
    const Track& track = result.tracks.front();
    CHECK(track.unseen_s == Approx(t - last_seen_s));
    CHECK(track.detection_index == -1);
    CHECK(track.detection.outer.ellipse.u_px == Approx(u()).margin(5));  // what noise there could have been
    CHECK(track.status == (t - last_seen_s > 2 + 1e-6 ? TrackStatus::lost : TrackStatus::predicted));
    CHECK_FALSE(reported_lost);
    reported_lost = track.status == TrackStatus::lost;
  }
  CHECK(reported_lost == (gap_s > 2.1));
  t = last_seen_s + gap_s;
  const auto result = tracker.step(t, kNoImage, {circle(u(), 100)});
  CHECK(track_of(result, 0).id == (gap_s < 2 ? 1 : 2));
}

TEST_CASE("the target is the first circle, not the first ellipse") {
  Tracker tracker{TrackerSettings{}};
  tracker.follow_first_circle();
  auto result = tracker.step(0, kNoImage, {circle(50, 50, 20, Label::unknown)});
  CHECK(result.target.status == TrackStatus::searching);
  CHECK(result.target.reason == "no circle in this frame");
  result = tracker.step(kFrame_s, kNoImage,
                        {circle(50, 50, 20, Label::cargo), circle(300, 300), circle(400, 300)});
  CHECK(result.target.status == TrackStatus::tracking);
  CHECK(result.target.id == track_of(result, 1).id);
}

TEST_CASE("the target by pixel: within two semi-axes, the ellipse that has it farthest inside") {
  Tracker tracker{TrackerSettings{}};
  tracker.follow_pixel({100, 141});
  auto result = tracker.step(0, kNoImage, {circle(100, 100)});
  CHECK(result.target.status == TrackStatus::searching);
  CHECK(result.target.reason == "no ellipse within two semi-axes of (100, 141)");
  result = tracker.step(kFrame_s, kNoImage, {circle(100, 102), circle(100, 150), circle(110, 115, 40)});
  CHECK(result.target.id == track_of(result, 1).id);
}

TEST_CASE("the target by id, and by the place it was last seen when the id is not known") {
  Tracker tracker{TrackerSettings{}};
  const std::vector<Detection> three = {circle(100, 100), circle(200, 100), circle(300, 100)};
  tracker.step(0, kNoImage, three);
  tracker.follow_id(2);
  auto result = tracker.step(kFrame_s, kNoImage, three);
  CHECK(result.target.id == 2);
  CHECK(track_of(result, 1).id == 2);

  tracker.follow_id(7);
  result = tracker.step(2 * kFrame_s, kNoImage, three);
  CHECK(result.target.status == TrackStatus::searching);
  CHECK(result.target.reason == "track 7 is not known");

  tracker.follow_id(7, Eigen::Vector2d(290, 110));
  result = tracker.step(3 * kFrame_s, kNoImage, three);
  CHECK(result.target.id == 3);
}

TEST_CASE("the same command again changes nothing") {
  Tracker tracker{TrackerSettings{}};
  double u = 100;
  TrackerResult result;
  for (int k = 0; k < 60; ++k, u += 3) {  // another circle soon stands where the command points
    tracker.follow_pixel({100, 100});
    std::vector<Detection> detections = {circle(u, 100)};
    if (k > 30) detections.insert(detections.begin(), circle(100, 100));
    result = tracker.step(k * kFrame_s, kNoImage, detections);
  }
  CHECK(result.target.id == 1);
  CHECK(result.target.status == TrackStatus::tracking);

  tracker.follow_id(1, Eigen::Vector2d(100, 100));  // the one it follows already: the window stays learned
  result = tracker.step(60 * kFrame_s, kNoImage, {circle(100, 100), circle(u, 100)});
  CHECK(result.target.id == 1);

  tracker.release();
  result = tracker.step(61 * kFrame_s, kNoImage, {circle(100, 100), circle(u + 3, 100)});
  CHECK(result.target.status == TrackStatus::searching);
  CHECK_FALSE(result.target.id);
  CHECK(result.target.reason == "no target is wanted");

  tracker.follow_pixel({100, 100});  // after a release it is a new wish
  result = tracker.step(62 * kFrame_s, kNoImage, {circle(100, 100), circle(u + 6, 100)});
  CHECK(result.target.id == 2);
}

TEST_CASE("a neighbour is never taken for a target that vanished") {
  const bool neighbour_known = GENERATE(true, false);
  const double distance = GENERATE(41.0, 50.0, 80.0);  // from just not touching
  Tracker tracker{TrackerSettings{}};
  tracker.follow_first_circle();
  TrackerResult result;
  int k = 0;
  for (; k < 20; ++k) {
    std::vector<Detection> detections = {circle(200, 200)};
    if (neighbour_known) detections.push_back(circle(200 + distance, 200));
    result = tracker.step(k * kFrame_s, kNoImage, detections);
  }
  for (; k < 110; ++k) {
    result = tracker.step(k * kFrame_s, kNoImage, {circle(200 + distance, 200)});
    CHECK(result.target.id == 1);
    CHECK(track_of(result, 0).id == 2);
    CHECK(result.target.status == (k < 80 ? TrackStatus::predicted : TrackStatus::lost));
  }
  CHECK(result.target.reason == "not seen for 2.0 s");
}

TEST_CASE("the reason names distance and reach") {
  Tracker tracker{TrackerSettings{}};
  tracker.follow_first_circle();
  tracker.step(0, kNoImage, {circle(200, 200)});
  auto result = tracker.step(kFrame_s, kNoImage, {circle(241, 200)});
  INFO(result.target.reason);
  CHECK(mentions(result.target.reason,
                 "nearest ellipse to the place its motion leads to is 41 px away, reach 20 px"));
  CHECK(mentions(result.target.reason, "no image in this frame"));
  result = tracker.step(2 * kFrame_s, kNoImage, {circle(200, 200, 8)});
  INFO(result.target.reason);
  CHECK(mentions(result.target.reason, "0.40 times as large as the target"));
  result = tracker.step(3 * kFrame_s, kNoImage, {});
  CHECK(mentions(result.target.reason, "no ellipse in this frame"));
}

TEST_CASE("a size that can't be the same object's starts a new track") {
  Tracker tracker{TrackerSettings{}};
  tracker.step(0, kNoImage, {circle(200, 200, 40), circle(200, 200, 12, Label::cargo)});
  const auto result =
      tracker.step(kFrame_s, kNoImage, {circle(201, 200, 12, Label::cargo), circle(203, 200, 40)});
  CHECK(track_of(result, 0).id == 2);
  CHECK(track_of(result, 1).id == 1);
}

TEST_CASE("time that goes back forgets velocities and keeps ids") {
  Tracker tracker{TrackerSettings{}};
  for (int k = 0; k < 30; ++k) tracker.step(100 + k * kFrame_s, kNoImage, {circle(100 + 5 * k, 100)});
  auto result = tracker.step(3, kNoImage, {circle(245, 100)});
  CHECK(track_of(result, 0).id == 1);
  CHECK(track_of(result, 0).velocity_pxps.norm() == 0);
  result = tracker.step(3 + kFrame_s, kNoImage, {circle(247, 100)});
  CHECK(track_of(result, 0).id == 1);
  CHECK(track_of(result, 0).velocity_pxps.x() == Approx(60).margin(3));
}

TEST_CASE("the same frame time twice neither moves nor loses anything") {
  Tracker tracker{TrackerSettings{}};
  for (int k = 0; k < 10; ++k) tracker.step(k * kFrame_s, kNoImage, {circle(100 + 5 * k, 100)});
  const auto result = tracker.step(9 * kFrame_s, kNoImage, {circle(145.5, 100)});
  CHECK(track_of(result, 0).id == 1);
  CHECK(track_of(result, 0).velocity_pxps.x() == Approx(150).margin(15));
}

TEST_CASE("a gap without frames longer than the memory loses the track") {
  Tracker tracker{TrackerSettings{}};
  tracker.step(0, kNoImage, {circle(100, 100)});
  const auto result = tracker.step(5, kNoImage, {circle(100, 100)});
  CHECK(track_of(result, 0).id == 2);
  CHECK(result.tracks.front().status == TrackStatus::lost);
}

TEST_CASE("detections that are no ellipses are passed over, indices stay those of the list") {
  Tracker tracker{TrackerSettings{}};
  const double nan = std::numeric_limits<double>::quiet_NaN(), huge = 1e300;
  tracker.follow_first_circle();
  const std::vector<Detection> detections = {circle(nan, 1),         circle(100, 100, 0),  circle(huge, 1),
                                             circle(100, 100, huge), circle(100, 100, -3), circle(100, 100)};
  for (int k = 0; k < 5; ++k) {
    const auto result = tracker.step(k * kFrame_s, cv::Mat::zeros(200, 200, CV_8U), detections);
    REQUIRE(result.tracks.size() == 1);
    CHECK(result.tracks[0].detection_index == 5);
    CHECK(result.target.status == TrackStatus::tracking);
  }
}

TEST_CASE("hundreds of detections, then none for long, then again") {
  Tracker tracker{TrackerSettings{}};
  std::vector<Detection> many;
  for (int i = 0; i < 400; ++i) many.push_back(circle(30 * (i % 20), 30 * (i / 20), 8));
  TrackerResult result;
  int k = 0;
  for (; k < 5; ++k) result = tracker.step(k * kFrame_s, kNoImage, many);
  REQUIRE(result.tracks.size() == 400);
  for (int i = 0; i < 400; ++i) CHECK(track_of(result, i).id == i + 1);
  for (; k < 300; ++k) result = tracker.step(k * kFrame_s, kNoImage, {});
  CHECK(result.tracks.empty());
  result = tracker.step(k * kFrame_s, kNoImage, many);
  CHECK(track_of(result, 0).id == 401);
}

TEST_CASE("a lone mark is followed however long there was nothing to see before") {
  FrameView view;
  view.size = {640, 480};
  if (GENERATE(false, true)) view.turn = Eigen::Matrix3d::Identity();
  Tracker tracker{TrackerSettings{}};
  int k = 0;
  for (; k < 600; ++k) tracker.step(k * kFrame_s, kNoImage, {}, view);
  for (; k < 610; ++k) {
    const auto result = tracker.step(k * kFrame_s, kNoImage, {circle(300, 200 + 0.5 * k)}, view);
    REQUIRE(result.tracks.size() == 1);
    CHECK(result.tracks[0].id == 1);
  }
}

TEST_CASE("the doubt about a mark that is not seen has no direction without doubt") {
  Tracker tracker{TrackerSettings{}};
  Detection oblique = circle(300, 200);
  oblique.outer.ellipse.b_px = 9;
  int k = 0;
  for (; k < 10; ++k) tracker.step(k * kFrame_s, kNoImage, {oblique, circle(100, 100)});
  for (; k < 13; ++k) {
    for (const Track& track : tracker.step(k * kFrame_s, kNoImage, {}).tracks) {
      const Ellipse& e = track.detection.outer.ellipse;
      EllipseCovariance relative = track.detection.outer.covariance;
      relative.row(2) /= e.a_px, relative.col(2) /= e.a_px;
      relative.row(3) /= e.b_px, relative.col(3) /= e.b_px;
      const Eigen::SelfAdjointEigenSolver<EllipseCovariance> axes(relative);
      CHECK(axes.eigenvalues().minCoeff() > 1e-4);  // a hundredth of size or form
    }
  }
}

TEST_CASE("strips of an image are followed by motion alone") {
  for (const cv::Size size : {cv::Size(640, 8), cv::Size(1, 5000), cv::Size(640, 2)}) {
    Tracker tracker{TrackerSettings{}};
    for (int k = 0; k < 4; ++k)
      CHECK(tracker.step(k * kFrame_s, cv::Mat(size, CV_8UC1, cv::Scalar(7)), {circle(3, 3, 2)})
                .tracks.size() == 1);
  }
}
