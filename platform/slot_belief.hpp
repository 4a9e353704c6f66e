// What is believed of one slot: Bayes over frames, slowly forgotten.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

namespace stevedore {

enum class SlotState { unknown, empty, occupied, misplaced };

class SlotBelief {
 public:
  /// The circle was seen, and no cargo; occupied as the detector says of it.
  void saw_circle(std::int64_t utime, std::optional<bool> occupied);
  /// A cargo was seen on the deck, that far from the slot's centre; inside_m: up to where it stands inside.
  void saw_cargo(std::int64_t utime, double offset_m, double offset_sigma_m, double inside_m);

  [[nodiscard]] SlotState state(std::int64_t utime) const;
  /// Of that state; of the likeliest for unknown. 1/3 when nothing is known.
  [[nodiscard]] double confidence(std::int64_t utime) const;
  [[nodiscard]] std::int64_t seen_utime() const { return seen_utime_; }

  /// The probabilities of empty, occupied, misplaced.
  [[nodiscard]] Eigen::Array3d probabilities(std::int64_t utime) const;
  /// Takes over probabilities, for a slot that may be one of several.
  void set(std::int64_t utime, const Eigen::Array3d& probabilities);

 private:
  void weigh(std::int64_t utime, const Eigen::Array3d& likelihood);

  Eigen::Array3d log_odds_ = Eigen::Array3d::Zero();  ///< up to a constant
  std::int64_t utime_ = 0;                            ///< of log_odds_
  std::int64_t seen_utime_ = -1;
  std::int64_t weighed_utime_ = 0;
};

}  // namespace stevedore
