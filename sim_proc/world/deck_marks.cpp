#include "sim_proc/world/deck_marks.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "sim_proc/world/paints.hpp"

namespace stevedore::world {
namespace {

using Eigen::Vector2d;
using Shape = Mark::Shape;
using std::numbers::pi;

/// Its bows, half as large, are nowhere near a circle's size.
constexpr double largest_letter_m = 0.7;

Mark bar(const Vector2d& from, const Vector2d& to, double width_m, const Surface& paint) {
  Mark mark;
  mark.shape = Shape::bar;
  mark.center_deck_m = (from + to) / 2;
  mark.length_m = (to - from).norm();
  mark.width_m = width_m;
  mark.angle_rad = std::atan2(to.y() - from.y(), to.x() - from.x());
  mark.paint = paint;
  return mark;
}

Mark round(Shape shape, const Vector2d& center, double radius_m, double width_m, const Surface& paint) {
  Mark mark;
  mark.shape = shape;
  mark.center_deck_m = center;
  mark.radius_m = radius_m;
  mark.width_m = width_m;
  mark.paint = paint;
  return mark;
}

/// Draws the marks of one deck, the lowest first.
class SignPainter {
 public:
  SignPainter(const Plan& plan, double circle_radius_m, const Surface& ground, Dice& dice)
      : plan_(plan), radius_m_(circle_radius_m), ground_(ground), dice_(dice) {}

  void seams() {
    const double pitch_m = dice_.uniform(0.5, 1.2), x = plan_.half_size_m.x(), y = plan_.half_size_m.y();
    const Surface dark = make_surface(ground_.colour * 0.45F, 0.1, 0.1, dice_);
    for (double at = -y + dice_.uniform(0.2, 1) * pitch_m; at < y; at += pitch_m)
      marks_.push_back(bar({-x, at}, {x, at}, dice_.uniform(0.008, 0.02), dark));
  }

  void border() {
    const double inset_m = 0.08, x = plan_.half_size_m.x() - inset_m, y = plan_.half_size_m.y() - inset_m;
    const Surface paint = other_paint();
    const double width_m = dice_.uniform(0.04, 0.1);
    const std::array<Vector2d, 4> corners = {Vector2d(-x, -y), {x, -y}, {x, y}, {-x, y}};
    for (size_t i = 0; i < corners.size(); ++i)
      marks_.push_back(bar(corners[i], corners[(i + 1) % corners.size()], width_m, paint));
  }

  void lines() {
    const Surface paint = other_paint();
    const Vector2d half = plan_.half_size_m;
    for (int i = dice_.whole(1, 3); i > 0; --i) {
      const double y = dice_.uniform(-half.y(), half.y()), x = dice_.uniform(-half.x(), half.x());
      const Vector2d from(x, y);
      const double angle = dice_.chance(0.6) ? dice_.whole(0, 3) * pi / 4 : dice_.uniform(0, pi);
      const Vector2d way(std::cos(angle), std::sin(angle));
      marks_.push_back(bar(from - way * 3, from + way * 3, dice_.uniform(0.03, 0.1), paint));
    }
  }

  void circles() {
    const bool discs = dice_.chance(0.3), own_colours = dice_.chance(0.25);
    const double width_m = dice_.uniform(0.07, 0.14), wear = dice_.uniform(0, 0.22);
    Eigen::Vector3f colour = draw_mark_colour(ground_.colour, dice_);
    for (size_t slot = 0; slot < plan_.slots_deck_m.size(); ++slot) {
      if (own_colours) colour = draw_mark_colour(ground_.colour, dice_);
      const Surface paint = make_surface(colour, dice_.uniform(0.04, 0.15), wear, dice_);
      Mark mark = round(discs ? Shape::disc : Shape::ring, plan_.slots_deck_m[slot], radius_m_,
                        discs ? 0 : width_m, paint);
      mark.slot = static_cast<int>(slot);
      marks_.push_back(mark);
    }
  }

  /// In the circles: a number, a cross, an inner ring; on some only.
  void insides() {
    const int kind = dice_.whole(0, 5);
    for (const Vector2d& center : plan_.slots_deck_m) {
      const Surface paint = inside_paint();
      if (kind == 0) letter(center, dice_.uniform(0.3, 0.5), paint);
      if (kind == 1) cross(center, dice_.uniform(0.2, 0.4), paint);
      if (kind == 2) {
        const double width_m = dice_.uniform(0.03, 0.08), radius_m = dice_.uniform(0.12, 0.3);
        marks_.push_back(round(Shape::ring, center, radius_m, width_m, paint));
      }
    }
  }

  /// Rings and discs of other sizes, arcs, letters, lids.
  void decoys() {
    for (int i = dice_.whole(2, 6); i > 0; --i) {
      const int kind = dice_.whole(0, 4);
      const double radius_m = draw_other_radius(radius_m_, 0.1, 0.9, dice_);
      const auto place = draw_free_place(plan_, radius_m_, radius_m, dice_);
      if (!place) continue;
      const Surface paint = other_paint();
      if (kind == 0) marks_.push_back(round(Shape::ring, *place, radius_m, radius_m * 0.2, paint));
      if (kind == 1) lid(*place, std::min(radius_m, 0.36));
      if (kind == 2) arc(*place, radius_m, paint);
      if (kind >= 3) letter(*place, std::min(radius_m * 1.2, largest_letter_m), paint);
    }
  }

  std::vector<Mark> take() { return std::move(marks_); }

 private:
  Surface other_paint() {
    const double wear = dice_.uniform(0, 0.35);
    const auto colour = draw_mark_colour(ground_.colour, dice_);
    return make_surface(colour, 0.1, wear, dice_);
  }
  Surface inside_paint() {
    for (const Mark& mark : marks_)
      if (mark.slot >= 0)
        return make_surface(mark.shape == Shape::disc ? ground_.colour : mark.paint.colour, 0.1,
                            dice_.uniform(0, 0.3), dice_);
    return other_paint();
  }

  void cross(const Vector2d& at, double size_m, const Surface& paint) {
    const double turn = dice_.whole(0, 1) * pi / 4;
    for (const double angle : {turn, turn + pi / 2}) {
      const Vector2d arm = size_m / 2 * Vector2d(std::cos(angle), std::sin(angle));
      marks_.push_back(bar(at - arm, at + arm, size_m * 0.16, paint));
    }
  }

  /// A manhole's lid or a hatch: dark disc, bright rim.
  void lid(const Vector2d& at, double radius_m) {
    const Surface rim = make_surface(Eigen::Vector3f(0.3F, 0.29F, 0.28F), 0.2, 0.2, dice_);
    const Surface plate = make_surface(ground_.colour * 0.6F, 0.3, 0, dice_);
    marks_.push_back(round(Shape::disc, at, radius_m, 0, plate));
    marks_.push_back(round(Shape::ring, at, radius_m, 0.025, rim));
  }

  void arc(const Vector2d& at, double radius_m, const Surface& paint) {
    Mark mark = round(Shape::arc, at, radius_m, dice_.uniform(0.04, 0.12), paint);
    mark.angle_rad = dice_.uniform(-pi, pi);
    mark.sweep_rad = dice_.uniform(0.8, 4);
    marks_.push_back(mark);
  }

  /// H, T, C, D or 8, as stencils paint them.
  void letter(const Vector2d& at, double size_m, const Surface& paint) {
    const double w = size_m * 0.3, h = size_m / 2, thick = size_m * 0.14, turn = dice_.whole(0, 3) * pi / 2;
    const auto point = [&](double x, double y) -> Vector2d {
      return at + Vector2d(std::cos(turn) * x - std::sin(turn) * y, std::sin(turn) * x + std::cos(turn) * y);
    };
    const auto stroke = [&](double x0, double y0, double x1, double y1) {
      marks_.push_back(bar(point(x0, y0), point(x1, y1), thick, paint));
    };
    const auto bow = [&](double x, double y, double radius_m, double from_rad, double sweep_rad) {
      Mark mark = round(Shape::arc, point(x, y), radius_m, thick, paint);
      mark.angle_rad = from_rad + turn;
      mark.sweep_rad = sweep_rad;
      marks_.push_back(mark);
    };
    switch (dice_.whole(0, 4)) {
      case 0:
        stroke(-h, -w, h, -w), stroke(-h, w, h, w), stroke(0, -w, 0, w);
        break;
      case 1:
        stroke(-h, 0, h, 0), stroke(h - thick / 2, -w, h - thick / 2, w);
        break;
      case 2:
        bow(0, 0, h, pi * 0.25 + pi / 2, pi * 1.5);
        break;
      case 3:
        stroke(-h, -w, h, -w), bow(0, -w, h, 0, pi);
        break;
      default:
        marks_.push_back(round(Shape::ring, point(h / 2, 0), h / 2 + thick / 2, thick, paint));
        marks_.push_back(round(Shape::ring, point(-h / 2, 0), h / 2 + thick / 2, thick, paint));
    }
  }

  const Plan& plan_;
  double radius_m_;
  const Surface& ground_;
  Dice& dice_;
  std::vector<Mark> marks_;
};

}  // namespace

Plan draw_plan(Layout layout, double circle_radius_m, Dice& dice) {
  Plan plan;
  if (layout == Layout::square) {
    const double half_m = dice.uniform(0.76, 0.84);
    plan.slots_deck_m = {{half_m, -half_m}, {half_m, half_m}, {-half_m, half_m}, {-half_m, -half_m}};
    plan.half_size_m = Vector2d::Constant(half_m + circle_radius_m + dice.uniform(0.35, 0.45));
    return plan;
  }
  const double pitch_m = dice.uniform(1.2, 1.45);
  for (int slot = 0; slot < 4; ++slot) plan.slots_deck_m.emplace_back((1.5 - slot) * pitch_m, 0);
  plan.half_size_m = {1.5 * pitch_m + circle_radius_m + dice.uniform(0.2, 0.4),
                      circle_radius_m + dice.uniform(0.2, 0.6)};
  return plan;
}

double draw_other_radius(double circle_radius_m, double lowest_m, double highest_m, Dice& dice) {
  // an eighth more apart than what could be mistaken
  const double below_m = circle_radius_m * (1 - 1.125 * circle_like);
  const double above_m = circle_radius_m * (1 + 1.125 * circle_like);
  const double small_m = std::max(0.0, std::min(below_m, highest_m) - lowest_m);
  const double large_m = std::max(0.0, highest_m - above_m);
  const double at = dice.uniform(0, small_m + large_m);
  return at < small_m ? lowest_m + at : above_m + (at - small_m);
}

std::optional<Vector2d> draw_free_place(const Plan& plan, double circle_radius_m, double radius_m,
                                        Dice& dice) {
  constexpr int most_draws = 30;
  constexpr double gap_m = 0.03;
  for (int i = 0; i < most_draws; ++i) {
    const double y = dice.uniform(-1, 1), x = dice.uniform(-1, 1);
    const Vector2d at(x * plan.half_size_m.x(), y * plan.half_size_m.y());
    bool is_free = true;
    for (const Vector2d& slot : plan.slots_deck_m)
      is_free = is_free && (at - slot).norm() > circle_radius_m + radius_m + gap_m;
    if (is_free) return at;
  }
  return std::nullopt;
}

std::vector<Mark> draw_marks(const Plan& plan, double circle_radius_m, const Surface& ground, bool clutter,
                             Dice& dice) {
  SignPainter painter(plan, circle_radius_m, ground, dice);
  if (clutter) {
    if (dice.chance(0.5)) painter.seams();
    if (dice.chance(0.4)) painter.border();
    if (dice.chance(0.3)) painter.lines();
    painter.decoys();
  }
  painter.circles();
  if (clutter) painter.insides();
  return painter.take();
}

}  // namespace stevedore::world
