#include "sim_proc/world/ray.hpp"

#include "sim_proc/world/shapes.hpp"

namespace stevedore::world {
namespace {

using Eigen::Vector3d;
using What = Hit::What;

/// The nearest so far.
struct Nearest {
  std::optional<Hit> hit;

  void offer(double range_m, What what, int index) {
    if (!hit || range_m < hit->range_m) hit = Hit{range_m, what, index};
  }
  void offer(const Meeting<double>& met, What what, int index) {
    if (met) offer(met.range, what, index);
  }
};

Ray<double> in_local(const Rigid& rigid, const Ray<double>& ned) {
  return {rigid.to_local(ned.origin), rigid.ned_from_local.conjugate() * ned.direction};
}

bool passes_by(const Ray<double>& ray, const Vector3d& centre, double radius_m) {
  const Vector3d to_centre = centre - ray.origin;
  return to_centre.cross(ray.direction).squaredNorm() > radius_m * radius_m;
}

void offer_bucket(const Ray<double>& ned, const Bucket& bucket, int index, Nearest& nearest) {
  const Ray<double> ray = in_local(bucket.rigid, ned);
  const double reach_m = bucket.height_m + bucket.handle_rise_m + bucket.rim_radius_m;
  if (passes_by(ray, Vector3d::Zero(), reach_m)) return;
  nearest.offer(meet_bucket(ray, frustum_of<double>(bucket)), What::bucket, index);
  const auto wire = handle_of(bucket);
  for (size_t i = 1; i < wire.size(); ++i)
    nearest.offer(meet_capsule(ray, wire[i - 1], wire[i], handle_wire_m), What::bucket, index);
}

void offer_strand(const Ray<double>& ray, const Strand& strand, int index, Nearest& nearest) {
  for (size_t i = 1; i < strand.points_ned_m.size(); ++i)
    nearest.offer(
        meet_capsule<double>(ray, strand.points_ned_m[i - 1], strand.points_ned_m[i], strand.radius_m),
        What::strand, index);
}

void offer_deck(const Ray<double>& ned, const Deck& deck, int index, Nearest& nearest) {
  const Vector3d lowest(-deck.half_size_m.x(), -deck.half_size_m.y(), 0);
  const Vector3d highest(deck.half_size_m.x(), deck.half_size_m.y(), deck.thickness_m);
  nearest.offer(meet_box(in_local(deck.rigid, ned), lowest, highest), What::deck, index);
}

void offer_surroundings(const Ray<double>& ray, Nearest& nearest) {
  const bool looks_down_on_it = ray.direction.z() > 0 && ray.origin.z() < 0;
  if (looks_down_on_it) nearest.offer(-ray.origin.z() / ray.direction.z(), What::surroundings, -1);
}

template <typename Things, typename Offer>
void offer_each(const Things& things, const Offer& offer) {
  for (size_t i = 0; i < things.size(); ++i) offer(things[i], static_cast<int>(i));
}

}  // namespace

std::optional<Hit> first_hit(const Scene& scene, const Vector3d& origin_ned_m,
                             const Vector3d& direction_ned) {
  const Ray<double> ray{origin_ned_m, direction_ned};
  Nearest nearest;
  offer_surroundings(ray, nearest);
  offer_each(scene.decks, [&](const Deck& deck, int i) { offer_deck(ray, deck, i, nearest); });
  offer_each(scene.buckets, [&](const Bucket& bucket, int i) { offer_bucket(ray, bucket, i, nearest); });
  offer_each(scene.tyres, [&](const Tyre& tyre, int i) {
    nearest.offer(meet_torus(in_local(tyre.rigid, ray), tyre.radius_m, tyre.tube_m), What::tyre, i);
  });
  offer_each(scene.capsules, [&](const Capsule& capsule, int i) {
    nearest.offer(meet_capsule(ray, capsule.from_ned_m, capsule.to_ned_m, capsule.radius_m), What::capsule,
                  i);
  });
  offer_each(scene.strands, [&](const Strand& strand, int i) { offer_strand(ray, strand, i, nearest); });
  return nearest.hit;
}

}  // namespace stevedore::world
