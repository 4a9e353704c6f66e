// How far along its course a platform is: cycles of driving, stopping and reversing.
#pragma once

#include <vector>

namespace stevedore::world {

/// A cycle of stretches. Within each the speed goes from the one before's to its own along half a cosine, so
/// that neither speed nor acceleration jumps; the last one leads over to the first.
class SpeedProfile {
 public:
  struct Stretch {
    double duration_s = 0;
    double end_mps = 0;
  };
  explicit SpeedProfile(std::vector<Stretch> cycle);

  struct At {
    double distance_m = 0;  ///< since time 0
    double speed_mps = 0;   ///< its derivative
  };
  [[nodiscard]] At at(double time_s) const;

  [[nodiscard]] double cycle_s() const { return cycle_s_; }
  [[nodiscard]] double middle_m() const;  ///< between the ends of a cycle that comes back to where it began

 private:
  struct Piece {
    double from_s, duration_s;
    double from_m;
    double from_mps, end_mps;

    [[nodiscard]] At at(double since_s) const;
  };
  std::vector<Piece> pieces_;
  double cycle_s_ = 0;
  double cycle_m_ = 0;
};

}  // namespace stevedore::world
