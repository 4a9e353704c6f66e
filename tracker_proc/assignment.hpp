// The cheapest pairing of two lists, in which either side may stay alone.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace stevedore {

/// For each row the column it is paired with, if any; each column is used once. `gain` (rows x columns) says
/// what pairing costs beyond leaving both alone, so only pairs below zero are worth making; their sum is as
/// low as it can be. Shortest augmenting paths (Jonker and Volgenant 1987), group by group: rows and columns
/// that no chain of such pairs connects can't disturb each other.
std::vector<std::optional<std::size_t>> assign(const Eigen::MatrixXd& gain);

}  // namespace stevedore
