// Between the vision code's types and the messages' types, for what several stages exchange.
#pragma once

#include <cstdint>
#include <stevedore/ellipse_t.hpp>
#include <stevedore/vehicle_state_t.hpp>

#include "geometry/detection.hpp"
#include "geometry/vehicle_history.hpp"

namespace stevedore {

ellipse_t to_message(const Detection& detection);

/// ellipse_t.LABEL_*
std::int8_t to_message(Label label);
Label label_of(std::int8_t label);

/// The message must have passed fault_of.
Detection from_message(const ellipse_t& message);
VehicleSample from_message(const vehicle_state_t& message);

}  // namespace stevedore
