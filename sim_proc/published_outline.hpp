// Where a circle really is in the frame that is published: the picture as the real lens took it, rectified
// with the lens that the pipeline is told.
#pragma once

#include <optional>

#include "geometry/camera_model.hpp"
#include "geometry/ellipse.hpp"
#include "sim_proc/world/scene.hpp"
#include "sim_proc/world/truth.hpp"

namespace stevedore {

/// A pixel of the true lens' ideal image goes through the true distortion into the image as given, and from
/// there through the told rectification. Nothing: the circle is not in view.
std::optional<Ellipse> published_outline(const world::Scene& scene, const world::CircleTruth& circle,
                                         const CameraModel& told);

}  // namespace stevedore
