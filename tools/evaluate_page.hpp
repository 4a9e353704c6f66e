// An evaluation as a page: one HTML file with everything in it.
#pragma once

#include <string>

#include "tools/evaluate_core.hpp"

namespace stevedore {

std::string to_html(const Evaluation& evaluation);

}  // namespace stevedore
