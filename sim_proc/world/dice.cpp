#include "sim_proc/world/dice.hpp"

#include <cmath>
#include <numbers>

namespace stevedore::world {
namespace {

/// Finalizer of splitmix64 (Steele, Lea, Flood 2014, with the constants of Stafford's variant 13).
std::uint64_t mixed(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/// FNV-1a, 64 bits (Fowler, Noll, Vo 1991).
std::uint64_t hash_of(std::string_view name) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char letter : name) {
    hash ^= static_cast<unsigned char>(letter);
    hash *= 0x100000001b3ULL;
  }
  return hash;
}

}  // namespace

Dice::Dice(std::uint64_t seed, std::string_view name) : state_(mixed(seed) ^ hash_of(name)) {}

std::uint64_t Dice::next() {
  state_ += 0x9e3779b97f4a7c15ULL;  // 2^64 over the golden ratio
  return mixed(state_);
}

double Dice::uniform(double lowest, double highest) {
  constexpr double to_unit = 0x1p-53;  // 53 bits: what a double holds
  return lowest + (highest - lowest) * (static_cast<double>(next() >> 11) * to_unit);
}

int Dice::whole(int lowest, int highest) {
  const auto span = static_cast<std::uint64_t>(highest - lowest) + 1;
  return lowest + static_cast<int>(((next() >> 32) * span) >> 32);
}

bool Dice::chance(double probability) {
  return uniform(0, 1) < probability;
}

double Dice::normal(double sigma) {
  const double radius = std::sqrt(-2 * std::log(1 - uniform(0, 1)));  // 1 - u is never 0
  return sigma * radius * std::cos(uniform(0, 2 * std::numbers::pi));
}

}  // namespace stevedore::world
