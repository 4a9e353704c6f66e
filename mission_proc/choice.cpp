#include "mission_proc/choice.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace stevedore {
namespace {

constexpr double failure_m = 3, neighbour_m = 0.5, unseen_mps = 0.2, most_unseen_m = 2, doubt_m = 2,
                 kept_m = 1, unwanted_m = 20;
constexpr int most_groped = 2;  // times that a cargo is felt for that nobody sees
constexpr double sure = 0.8;    // confidence: one of five such decks would be judged wrong at worst

const char* word(SlotCondition condition) {
  switch (condition) {
    case SlotCondition::unknown:
      return "nobody knows yet whether a cargo stands in it";
    case SlotCondition::empty:
      return "no cargo stands in it";
    case SlotCondition::occupied:
      return "a cargo stands in it";
    case SlotCondition::misplaced:
      return "a cargo stands across its edge";
  }
  return "";
}

const char* words_of_last_resort(bool loaded) {
  return loaded ? ", but nobody brought it, and no circle is told free"
                : ", but nobody took it away, and there was one in each circle";
}

std::string objection(std::size_t index, const ChoiceInputs& inputs, int failures) {
  const SlotReport& slot = inputs.deck->news().slots[index];
  const bool done = index < inputs.done.size() && inputs.done[index];
  if (done && inputs.loaded) return "a cargo was brought there";
  if (done && inputs.last_resort) return "its cargo was taken away";
  const SlotCondition wanted = inputs.loaded ? SlotCondition::empty : SlotCondition::occupied;
  if (!inputs.last_resort && slot.condition != wanted) return word(slot.condition);
  if (!inputs.last_resort && slot.confidence < sure)
    return fmt::format("{}, but only {:.0f} % sure", word(slot.condition), 100 * slot.confidence);
  const int most_failures = inputs.last_resort && !inputs.loaded ? most_groped : inputs.most_failures;
  if (failures >= most_failures) return fmt::format("left alone after {} failures", failures);
  return {};
}

double chance_of_occupied(const SlotReport& slot) {
  if (slot.condition == SlotCondition::unknown) return 0.5;
  return slot.condition == SlotCondition::empty ? 1 - slot.confidence : slot.confidence;
}

/// Circles so near that a cargo in them is in the way: the nearest ones, not those across a square (1.41
/// times as far).
int occupied_neighbours(const DeckPath& deck, std::size_t slot) {
  const auto& slots = deck.news().slots;
  double nearest_m = 1e9;
  for (std::size_t i = 0; i < slots.size(); ++i)
    if (i != slot) nearest_m = std::min(nearest_m, (deck.place_of(i) - deck.place_of(slot)).norm());
  int count = 0;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const bool next = i != slot && (deck.place_of(i) - deck.place_of(slot)).norm() < 1.3 * nearest_m;
    if (next && slots[i].condition != SlotCondition::empty) ++count;
  }
  return count;
}

void weigh(SlotCandidate& candidate, const ChoiceInputs& inputs, int failures) {
  const DeckPath& deck = *inputs.deck;
  const auto index = static_cast<std::size_t>(candidate.slot.slot);
  const SlotReport& slot = deck.news().slots[index];
  const double way_m =
      (deck.point(deck.place_of(index), 0, inputs.utime).position_m.head<2>() - inputs.hook_odometry_m)
          .norm();
  const int neighbours = occupied_neighbours(deck, index);
  const double unseen_s =
      slot.seen_utime < 0 ? 1e9 : static_cast<double>(inputs.utime - slot.seen_utime) * 1e-6;
  const bool kept = inputs.kept == candidate.slot;
  const double unseen_m = std::min(most_unseen_m, unseen_mps * std::max(0.0, unseen_s));
  const double occupied = chance_of_occupied(slot);
  const double unsure_m = inputs.last_resort ? unwanted_m * (inputs.loaded ? occupied : 1 - occupied)
                                             : doubt_m * (1 - slot.confidence);
  candidate.cost =
      way_m + failure_m * failures + neighbour_m * neighbours + unseen_m + unsure_m - (kept ? kept_m : 0);
  const std::string seen =
      slot.seen_utime < 0 ? "never seen" : fmt::format("seen {:.1f} s ago", std::max(0.0, unseen_s));
  candidate.reason = fmt::format(
      "{:.1f} m away, +{:.1f} ({} failures), +{:.1f} ({} not empty beside it), +{:.1f} ({}), +{:.1f} ({:.0f} "
      "% "
      "sure){}",
      way_m, failure_m * failures, failures, neighbour_m * neighbours, neighbours, unseen_m, seen, unsure_m,
      100 * slot.confidence, kept ? fmt::format(", -{:.1f} (chosen before)", kept_m) : "");
}

}  // namespace

std::vector<SlotCandidate> weigh_slots(const ChoiceInputs& inputs) {
  std::vector<SlotCandidate> candidates;
  if (!inputs.deck) return candidates;
  const auto& slots = inputs.deck->news().slots;
  SlotCandidate* best = nullptr;
  candidates.reserve(slots.size());
  for (std::size_t i = 0; i < slots.size(); ++i) {
    SlotCandidate& candidate = candidates.emplace_back();
    candidate.slot = {inputs.deck->news().platform, static_cast<int>(i)};
    const int failures = i < inputs.failures.size() ? inputs.failures[i] : 0;
    weigh(candidate, inputs, failures);
    const std::string against = objection(i, inputs, failures);
    candidate.eligible = against.empty();
    const bool despite = candidate.eligible && inputs.last_resort;
    candidate.reason = fmt::format("{}{}: {}", candidate.eligible ? word(slots[i].condition) : against,
                                   despite ? words_of_last_resort(inputs.loaded) : "", candidate.reason);
    const bool wished = inputs.wished == candidate.slot;
    if (wished && candidate.eligible) {
      candidate.cost -= 1000;
      candidate.reason += ", the operator's choice";
    }
    if (candidate.eligible && (!best || candidate.cost < best->cost)) best = &candidate;
  }
  if (best) best->chosen = true;
  return candidates;
}

}  // namespace stevedore
