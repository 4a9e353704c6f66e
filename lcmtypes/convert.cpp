#include "lcmtypes/convert.hpp"

#include <Eigen/Core>

namespace stevedore {
namespace {

using RowMajorCovariance = Eigen::Matrix<double, 5, 5, Eigen::RowMajor>;

ellipse_shape_t to_message(const EllipseFit& fit) {
  ellipse_shape_t message{};
  message.u_px = fit.ellipse.u_px;
  message.v_px = fit.ellipse.v_px;
  message.a_px = fit.ellipse.a_px;
  message.b_px = fit.ellipse.b_px;
  message.alpha_rad = fit.ellipse.alpha_rad;
  Eigen::Map<RowMajorCovariance>(message.covariance) = fit.covariance;
  return message;
}

EllipseFit from_message(const ellipse_shape_t& message) {
  return {{message.u_px, message.v_px, message.a_px, message.b_px, message.alpha_rad},
          Eigen::Map<const RowMajorCovariance>(message.covariance)};
}

}  // namespace

std::int8_t to_message(Label label) {
  switch (label) {
    case Label::unknown:
      return ellipse_t::LABEL_UNKNOWN;
    case Label::circle:
      return ellipse_t::LABEL_CIRCLE;
    case Label::cargo:
      return ellipse_t::LABEL_CARGO;
  }
  return ellipse_t::LABEL_UNKNOWN;
}

Label label_of(std::int8_t label) {
  return label == ellipse_t::LABEL_CIRCLE  ? Label::circle
         : label == ellipse_t::LABEL_CARGO ? Label::cargo
                                           : Label::unknown;
}

ellipse_t to_message(const Detection& detection) {
  ellipse_t message{};
  message.outer = to_message(detection.outer);
  message.has_inner = detection.inner.has_value();
  if (detection.inner) message.inner = to_message(*detection.inner);
  message.error = detection.error;
  message.coverage = detection.coverage;
  message.kind = detection.kind == Kind::whole ? ellipse_t::KIND_WHOLE : ellipse_t::KIND_PARTIAL;
  message.label = to_message(detection.label);
  message.occupied = !detection.occupied   ? ellipse_t::OCCUPIED_UNKNOWN
                     : *detection.occupied ? ellipse_t::OCCUPIED_YES
                                           : ellipse_t::OCCUPIED_NO;
  return message;
}

Detection from_message(const ellipse_t& message) {
  Detection detection;
  detection.outer = from_message(message.outer);
  if (message.has_inner) detection.inner = from_message(message.inner);
  detection.error = message.error;
  detection.coverage = message.coverage;
  detection.kind = message.kind == ellipse_t::KIND_WHOLE ? Kind::whole : Kind::partial;
  detection.label = label_of(message.label);
  if (message.occupied != ellipse_t::OCCUPIED_UNKNOWN)
    detection.occupied = message.occupied == ellipse_t::OCCUPIED_YES;
  return detection;
}

VehicleSample from_message(const vehicle_state_t& message) {
  const auto vector_of = [](const double(&values)[3]) { return Eigen::Map<const Eigen::Vector3d>(values); };
  const double(&q)[4] = message.ned_from_body;
  VehicleSample sample;
  sample.utime = message.header.utime;
  sample.position_ned_m = vector_of(message.position_ned_m);
  sample.velocity_ned_mps = vector_of(message.velocity_ned_mps);
  sample.ned_from_body = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  sample.angular_rate_body_radps = vector_of(message.angular_rate_body_radps);
  sample.velocity_variance_m2ps2 = vector_of(message.velocity_variance_m2ps2).mean();
  sample.attitude_variance_rad2 = vector_of(message.attitude_variance_rad2).mean();
  return sample;
}

}  // namespace stevedore
