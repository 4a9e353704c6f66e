#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tracker_proc/appearance.hpp"
#include "tracker_proc/tracker.hpp"

using namespace stevedore;

namespace {

constexpr double kFrame_s = 1.0 / 30;

const cv::Scalar kWhite(250, 250, 250), kDark(40, 40, 40), kRed(30, 30, 200), kGreen(40, 160, 40);

/// A filled ellipse on an even ground, as grey or BGR frame.
cv::Mat picture(const Ellipse& e, int type, const cv::Scalar& paint, const cv::Scalar& ground) {
  cv::Mat image(480, 640, type, ground);
  const auto fixed = [](double px) { return cvRound(px * 16); };
  cv::ellipse(image, {fixed(e.u_px), fixed(e.v_px)}, {fixed(e.a_px), fixed(e.b_px)},
              e.alpha_rad * 180 / 3.14159265358979, 0, 360, paint, cv::FILLED, cv::LINE_8, 4);
  return image;
}

Detection seen(const Ellipse& e) {
  Detection d;
  d.outer.ellipse = e;
  d.label = Label::circle;
  return d;
}

bool mentions(const std::string& sentence, const std::string& words) {
  return sentence.find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("tangent rectangle of a turned ellipse, and at the border") {
  const cv::Rect upright = tangent_rectangle({100, 50, 30, 10, 0}, {640, 480});
  CHECK(upright == cv::Rect(70, 40, 61, 21));
  CHECK(tangent_rectangle({100, 50, 30, 10, 1.5707963}, {640, 480}) == cv::Rect(90, 20, 21, 61));
  CHECK(tangent_rectangle({0, 0, 30, 10, 0}, {640, 480}) == cv::Rect(0, 0, 31, 11));
  CHECK(tangent_rectangle({-100, 50, 30, 10, 0}, {640, 480}).empty());
  CHECK(tangent_rectangle({100, 50, 30, 10, 0}, {0, 0}).empty());
}

TEST_CASE("eq. (6), to the bit") {
  const cv::Mat h = (cv::Mat_<float>(3, 1) << 1.0F, 0.0F, 0.0F);
  const cv::Mat now = (cv::Mat_<float>(3, 1) << 0.0F, 0.5F, 0.5F);
  const cv::Mat next = updated_histogram(h, now, 0.95);
  CHECK(next.at<float>(0) == Approx(0.95));
  CHECK(next.at<float>(1) == Approx(0.025));
  CHECK(next.at<float>(2) == Approx(0.025));
  CHECK(cv::countNonZero(updated_histogram(h, now, 1) != h) == 0);
  CHECK(cv::countNonZero(updated_histogram(h, now, 0) != now) == 0);
}

TEST_CASE("the appearance learns by eq. (6) from the ellipse's area alone") {
  const Ellipse e{200, 200, 40, 25, 0.3};
  Appearance appearance(0.95);
  appearance.learn(picture(e, CV_8UC1, 250, 40), e);
  const cv::Mat first = appearance.histogram().clone();
  CHECK(cv::sum(first)[0] == Approx(1));
  double largest = 0;
  cv::Point where;
  cv::minMaxLoc(first, nullptr, &largest, nullptr, &where);
  CHECK(largest > 0.99);  // the ground at its corners stays outside
  appearance.learn(picture(e, CV_8UC1, 120, 40), e);
  CHECK(appearance.histogram().at<float>(where) == Approx(0.95 * largest).margin(1e-6));
  CHECK(cv::sum(appearance.histogram())[0] == Approx(1));
}

TEST_CASE("features: hue where there is colour, grey level elsewhere") {
  const auto feature = [](cv::Vec3b bgr) {
    return int(feature_image(cv::Mat(1, 1, CV_8UC3, cv::Scalar(bgr))).at<uchar>(0));
  };
  CHECK(feature({0, 0, 200}) == 0);
  CHECK(feature({0, 200, 0}) == 60);
  CHECK(feature({200, 0, 0}) == 120);
  CHECK(feature({255, 255, 255}) == 251);
  CHECK(feature({0, 0, 0}) == 180);
  CHECK(feature({20, 0, 0}) >= 180);  // too dark for a hue
  CHECK(feature({130, 100, 110}) >= 180);
  CHECK(feature({200, 200, 200}) == int(feature_image(cv::Mat(1, 1, CV_8U, cv::Scalar(200))).at<uchar>(0)));
}

TEST_CASE("CAMShift finds a blob that moved, with its size and direction, on grey and on colour") {
  struct Scene {
    int type;
    cv::Scalar paint, ground;
  };
  const Scene scene = GENERATE(values<Scene>({{CV_8UC1, kWhite, kDark},
                                              {CV_8UC1, kDark, kWhite},
                                              {CV_8UC3, kRed, kGreen},
                                              {CV_8UC3, kWhite, kDark},
                                              {CV_8UC3, kWhite, kGreen}}));
  const Ellipse before{300, 200, 50, 25, 0.5}, after{330, 220, 54, 27, 0.7};
  Appearance appearance(0.95);
  appearance.learn(picture(before, scene.type, scene.paint, scene.ground), before);
  const WindowSearch search = appearance.find(picture(after, scene.type, scene.paint, scene.ground), before);
  CHECK(search.fault == "");
  REQUIRE(search.window);
  CHECK(search.window->u_px == Approx(after.u_px).margin(2));
  CHECK(search.window->v_px == Approx(after.v_px).margin(2));
  CHECK(search.window->a_px == Approx(after.a_px).epsilon(0.1));
  CHECK(search.window->b_px == Approx(after.b_px).epsilon(0.1));
  CHECK(search.window->alpha_rad == Approx(after.alpha_rad).margin(0.05));
}

TEST_CASE("CAMShift finds a thin ring whose area is mostly the ground that lies around it as well") {
  const Ellipse before{300, 200, 50, 45, 0}, after{320, 185, 50, 45, 0};
  const auto ring = [](const Ellipse& e) {
    cv::Mat image = picture(e, CV_8UC1, kWhite, kDark);
    const Ellipse hole{e.u_px, e.v_px, e.a_px - 7, e.b_px - 7, e.alpha_rad};
    cv::min(image, picture(hole, CV_8UC1, kDark, kWhite), image);
    return image;
  };
  Appearance appearance(0.95);
  appearance.learn(ring(before), before);
  const WindowSearch search = appearance.find(ring(after), before);
  CHECK(search.fault == "");
  REQUIRE(search.window);
  // mean shift feels the far side of a ring weakly and stops early, but on the way there and well inside the
  // gate
  CHECK(std::hypot(search.window->u_px - after.u_px, search.window->v_px - after.v_px) < 20);
  CHECK(search.window->u_px > before.u_px + 3);
}

TEST_CASE("windows that are of no use say why") {
  const Ellipse e{300, 200, 40, 30, 0};
  const cv::Mat image = picture(e, CV_8UC1, kWhite, kDark);
  Appearance appearance(0.95);
  CHECK(mentions(appearance.find(image, e).fault, "too little"));
  appearance.learn({}, e);
  appearance.learn(image, {-500, 0, 20, 20, 0});
  appearance.learn(image, {300, 200, 1, 1, 0});
  CHECK(appearance.histogram().empty());
  appearance.learn(image, e);
  CHECK(appearance.find({}, e).fault == "no image in this frame");
  CHECK(appearance.find(cv::Mat(9, 9, CV_32F, 0.0), e).fault == "no image in this frame");
  CHECK(mentions(appearance.find(image, {-500, 0, 20, 20, 0}).fault, "left the image"));
  CHECK(mentions(appearance.find(cv::Mat(480, 640, CV_8U, kDark), e).fault, "nothing that looks like"));
  CHECK(mentions(appearance.find(cv::Mat(480, 640, CV_8U, kWhite), e).fault, "background looks like"));
  CHECK(mentions(appearance.find(cv::Mat(480, 640, CV_8UC3, kWhite), e).fault, "colour and grey"));
  const Ellipse round{300, 200, 20, 20,
                      0};  // the rectangle's corner touches something else of the same paint
  CHECK(mentions(appearance.find(picture({336, 236, 26, 26, 0}, CV_8UC1, kWhite, kDark), round).fault,
                 "ran away"));
  const Ellipse small{300, 200, 7, 6, 0};
  CHECK(mentions(appearance.find(cv::Mat(480, 640, CV_8U, kWhite), small).fault, "leaked"));
  const cv::Mat speck = picture({300, 200, 6, 4, 0}, CV_8UC1, kWhite, kDark);
  CHECK(mentions(appearance.find(speck, e).fault, "collapsed"));
}

TEST_CASE("a jump that the motion model misses is followed through CAMShift") {
  const bool with_image = GENERATE(true, false);
  Tracker tracker{TrackerSettings{}};
  tracker.follow_first_circle();
  const auto at = [](double u) { return Ellipse{u, 240, 30, 24, 0}; };
  TrackerResult result;
  double u = 200;
  for (int k = 0; k < 20; ++k) {
    u = k < 10 ? 200 : 248;  // the camera is knocked: 48 px, 1.8 radii
    const cv::Mat image = with_image ? picture(at(u), CV_8UC1, kWhite, kDark) : cv::Mat();
    result = tracker.step(k * kFrame_s, image, {seen(at(u))});
    if (k == 10 && with_image) {
      CHECK(mentions(result.target.reason, "from the CAMShift window"));
      REQUIRE(result.target.window);
      CHECK(result.target.window->u_px == Approx(u).margin(2));
    }
  }
  CHECK(result.target.status == (with_image ? TrackStatus::tracking : TrackStatus::predicted));
}

TEST_CASE("white on white: CAMShift is no help, motion carries on and says so") {
  Tracker tracker{TrackerSettings{}};
  tracker.follow_first_circle();
  TrackerResult result;
  for (int k = 0; k < 30; ++k) {
    const Ellipse e{200.0 + 4 * k, 240, 30, 24, 0};
    result = tracker.step(k * kFrame_s, picture(e, CV_8UC1, kWhite, kWhite), {seen(e)});
    REQUIRE(result.target.status == TrackStatus::tracking);
    CHECK(result.target.id == 1);
  }
  CHECK(mentions(result.target.reason, "the place its motion leads to"));
  CHECK(mentions(result.target.reason, "CAMShift saw nothing that looks like the target"));
}

// ... which is detected for the first time when the target goes: no track of its own protects the target.
TEST_CASE("a neighbour of the same paint is not taken when the target is covered") {
  const double distance = GENERATE(62.0, 75.0);
  Tracker tracker{TrackerSettings{}};
  tracker.follow_first_circle();
  const Ellipse target{200, 240, 30, 28, 0}, neighbour{200 + distance, 240, 30, 28, 0};
  TrackerResult result;
  for (int k = 0; k < 90; ++k) {
    const bool covered = k >= 20;
    cv::Mat image = picture(neighbour, CV_8UC1, kWhite, kDark);
    if (!covered) image = cv::max(image, picture(target, CV_8UC1, kWhite, kDark));
    result = tracker.step(k * kFrame_s, image, {seen(covered ? neighbour : target)});
    CHECK(result.target.id == 1);
    CHECK(result.target.status != TrackStatus::searching);
    for (const Track& track : result.tracks)
      if (track.id == 1 && covered) CHECK(track.detection_index == -1);
  }
  CHECK(result.target.status == TrackStatus::lost);
}

TEST_CASE("frames that change between grey, colour, sizes and nothing do not lose the target") {
  Tracker tracker{TrackerSettings{}};
  tracker.follow_first_circle();
  const Ellipse e{100, 100, 30, 24, 0};
  for (int k = 0; k < 60; ++k) {
    cv::Mat image = picture(e, k % 3 == 0 ? CV_8UC1 : CV_8UC3, kWhite, kDark);
    if (k % 5 == 1) image = image(cv::Rect(0, 0, 320, 240));
    if (k % 5 == 2) image = image(cv::Rect(0, 0, 90, 90));
    if (k % 5 == 3) image = image(cv::Rect(0, 0, 1, 1));
    if (k % 5 == 4) image = cv::Mat();
    const auto result = tracker.step(k * kFrame_s, image, {seen(e)});
    REQUIRE(result.target.status == TrackStatus::tracking);
    CHECK(result.target.id == 1);
  }
}
