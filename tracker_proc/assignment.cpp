#include "tracker_proc/assignment.hpp"

#include <limits>
#include <utility>

namespace stevedore {
namespace {

using Index = Eigen::Index;
using Match = std::vector<std::optional<std::size_t>>;

/// Rows and columns that chains of useful pairs connect.
struct Group {
  std::vector<Index> rows, columns;
};

class Grouping {
 public:
  explicit Grouping(const Eigen::MatrixXd& gain)
      : gain_(gain),
        row_done_(static_cast<std::size_t>(gain.rows())),
        column_done_(static_cast<std::size_t>(gain.cols())) {}

  std::vector<Group> groups() {
    std::vector<Group> all;
    for (Index row = 0; row < gain_.rows(); ++row) {
      if (row_done_[static_cast<std::size_t>(row)]) continue;
      all.push_back(from(row));
      if (all.back().columns.empty()) all.pop_back();
    }
    return all;
  }

 private:
  Group from(Index first_row) {
    Group group;
    add(first_row, row_done_, group.rows);
    std::size_t rows_seen = 0, columns_seen = 0;
    while (rows_seen < group.rows.size() || columns_seen < group.columns.size()) {
      if (rows_seen < group.rows.size()) {
        const Index row = group.rows[rows_seen++];
        for (Index column = 0; column < gain_.cols(); ++column)
          if (gain_(row, column) < 0) add(column, column_done_, group.columns);
      } else {
        const Index column = group.columns[columns_seen++];
        for (Index row = 0; row < gain_.rows(); ++row)
          if (gain_(row, column) < 0) add(row, row_done_, group.rows);
      }
    }
    return group;
  }

  static void add(Index index, std::vector<bool>& done, std::vector<Index>& list) {
    if (done[static_cast<std::size_t>(index)]) return;
    done[static_cast<std::size_t>(index)] = true;
    list.push_back(index);
  }

  const Eigen::MatrixXd& gain_;
  std::vector<bool> row_done_, column_done_;
};

/// Every row of `cost` gets a column (rows <= columns); the sum is least.
class ShortestPaths {
 public:
  explicit ShortestPaths(const Eigen::MatrixXd& cost)
      : cost_(cost),
        row_price_(Eigen::VectorXd::Zero(cost.rows())),
        column_price_(Eigen::VectorXd::Zero(cost.cols())),
        row_of_(static_cast<std::size_t>(cost.cols()), kNone) {}

  std::vector<Index> row_of_column() {
    for (Index row = 0; row < cost_.rows(); ++row) augment(row);
    return row_of_;
  }

 private:
  static constexpr Index kNone = -1;

  /// Dijkstra over reduced costs from an unpaired row to the nearest free column; then the pairs along the
  /// path change sides.
  void augment(Index start) {
    Eigen::VectorXd distance =
        Eigen::VectorXd::Constant(cost_.cols(), std::numeric_limits<double>::infinity());
    std::vector<Index> came_from(row_of_.size(), kNone);  // column before this one on the path
    std::vector<bool> settled(row_of_.size(), false);
    std::vector<Index> path;
    double length = 0;
    Index row = start, last = kNone;
    while (true) {
      Index next = kNone;
      for (Index c = 0; c < cost_.cols(); ++c) {
        const auto k = static_cast<std::size_t>(c);
        if (settled[k]) continue;
        const double through = length + cost_(row, c) - row_price_[row] - column_price_[c];
        if (through < distance[c]) distance[c] = through, came_from[k] = last;
        if (next == kNone || distance[c] < distance[next]) next = c;
      }
      length = distance[next];
      settled[static_cast<std::size_t>(next)] = true;
      last = next;
      row = row_of_[static_cast<std::size_t>(next)];
      if (row == kNone) break;
      path.push_back(next);
    }
    row_price_[start] += length;
    for (const Index c : path) {
      row_price_[row_of_[static_cast<std::size_t>(c)]] += length - distance[c];
      column_price_[c] -= length - distance[c];
    }
    for (Index c = last; c != kNone;) {
      const Index before = came_from[static_cast<std::size_t>(c)];
      row_of_[static_cast<std::size_t>(c)] =
          before == kNone ? start : row_of_[static_cast<std::size_t>(before)];
      c = before;
    }
  }

  const Eigen::MatrixXd& cost_;
  Eigen::VectorXd row_price_, column_price_;
  std::vector<Index> row_of_;
};

void solve(const Eigen::MatrixXd& gain, const Group& group, Match& match) {
  const auto rows = static_cast<Index>(group.rows.size()), columns = static_cast<Index>(group.columns.size());
  // one more column for each row, of cost zero: to stay alone. Useless pairs cost as much.
  Eigen::MatrixXd cost = Eigen::MatrixXd::Zero(rows, columns + rows);
  for (Index r = 0; r < rows; ++r)
    for (Index c = 0; c < columns; ++c)
      cost(r, c) = std::min(
          0.0, gain(group.rows[static_cast<std::size_t>(r)], group.columns[static_cast<std::size_t>(c)]));
  const std::vector<Index> row_of = ShortestPaths(cost).row_of_column();
  for (Index c = 0; c < columns; ++c) {
    const Index r = row_of[static_cast<std::size_t>(c)];
    if (r < 0 || !(cost(r, c) < 0)) continue;
    match[static_cast<std::size_t>(group.rows[static_cast<std::size_t>(r)])] =
        static_cast<std::size_t>(group.columns[static_cast<std::size_t>(c)]);
  }
}

}  // namespace

Match assign(const Eigen::MatrixXd& gain) {
  Match match(static_cast<std::size_t>(gain.rows()));
  for (const Group& group : Grouping(gain).groups()) solve(gain, group, match);
  return match;
}

}  // namespace stevedore
