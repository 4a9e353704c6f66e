#pragma once

namespace stevedore::world {

constexpr double gravity_mps2 = 9.81;

}  // namespace stevedore::world
