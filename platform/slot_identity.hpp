// Which of the ways a symmetric layout can be turned is the real one: a square looks the same after every
// quarter turn, a row after a half.
#pragma once

#include <vector>

namespace stevedore {

/// Heading as published = heading as the filter counts it + turns() * period.
class SlotIdentity {
 public:
  explicit SlotIdentity(double period_rad = 0, int periods = 1);

  /// The deck was found again, its heading off the predicted one by residual (within half a period), when the
  /// prediction had this standard deviation. Returns the probability of each number of periods that the
  /// prediction may have slipped, in the direction of growing heading.
  std::vector<double> found(double residual_rad, double sigma_rad);

  /// The platform told a heading; off: against the filter's, not turned.
  void told(double off_rad, double sigma_rad);

  [[nodiscard]] int turns() const { return turns_; }
  /// All other ways together are less likely than what lies beyond three sigma.
  [[nodiscard]] bool certain() const;
  /// Variance that the ways not chosen add to the heading.
  [[nodiscard]] double spread_rad2() const;

 private:
  void choose();

  double period_rad_;
  std::vector<double> probability_;  ///< of each number of periods
  int turns_ = 0;
};

}  // namespace stevedore
