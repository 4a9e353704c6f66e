#include "sim_proc/world/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <variant>
#include <vector>

#include "sim_proc/world/develop.hpp"
#include "sim_proc/world/motion.hpp"
#include "sim_proc/world/planes.hpp"
#include "sim_proc/world/solids.hpp"
#include "sim_proc/world/strands.hpp"
#include "sim_proc/world/workers.hpp"

namespace stevedore::world {
namespace {

/// Rows that are drawn, and developed, as one piece of work.
constexpr int piece_rows = 24;

/// Memory of one thread.
struct Scratch {
  PlaneRow deck_row, ground_row;
  Solid::Scratch solid;
  std::vector<float> strand_shares;
  std::vector<std::uint8_t> covered;
  DevelopScratch develop;

  void resize(int width) {
    deck_row.resize(width);
    ground_row.resize(width);
    strand_shares.assign(static_cast<size_t>(width), 0.0F);
    covered.resize(static_cast<size_t>(width));
  }
};

Strand handle_strand(const Bucket& bucket) {
  Strand wire;
  wire.radius_m = handle_wire_m;
  wire.surface.colour = {0.35F, 0.35F, 0.36F};  // galvanized
  for (const Eigen::Vector3d& point : handle_of(bucket))
    wire.points_ned_m.push_back(bucket.rigid.to_ned(point));
  return wire;
}

std::vector<size_t> farthest_first(const Scene& scene) {
  std::vector<size_t> order(scene.decks.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto distance2 = [&](size_t i) {
    return (scene.decks[i].rigid.position_ned_m - scene.eye.rigid.position_ned_m).squaredNorm();
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return distance2(a) > distance2(b); });
  return order;
}

/// A scene made ready to be drawn row by row.
class Stage {
 public:
  Stage(const Scene& scene, const LensRays& rays)
      : scene_(scene), view_(scene.eye, rays), motions_(scene), ground_(view_, scene) {
    for (const size_t i : farthest_first(scene)) decks_.emplace_back(view_, scene, i, motions_.deck(i));
    add_solids();
    add_strands();
    // painter's order, the farthest first
    std::stable_sort(things_.begin(), things_.end(),
                     [](const Thing& a, const Thing& b) { return a.distance_m > b.distance_m; });
  }

  [[nodiscard]] const View& view() const { return view_; }
  [[nodiscard]] const Motions& motions() const { return motions_; }

  /// Rows first..last-1.
  void draw(int first, int last, const Textures& textures, Scratch& scratch, Picture& picture) const {
    for (int v = first; v < last; ++v) draw_ground(v, textures, scratch, PictureRow(picture, v));
    for (const DeckLayer& deck : decks_) {
      deck.draw_body(textures, first, last, picture, scratch.solid);
      for (int v = first; v < last; ++v)
        if (deck.meet(v, scratch.deck_row)) deck.draw_top(textures, scratch.deck_row, PictureRow(picture, v));
    }
    for (const Thing& thing : things_) {
      if (const auto* solid = std::get_if<Solid>(&thing.what))
        solid->draw(view_.rays, scene_.light, textures, first, last, picture, scratch.solid);
      else
        std::get<SeenStrand>(thing.what).draw(scene_.light, first, last, picture, scratch.strand_shares);
    }
    for (int v = first; v < last; ++v) add_haze(scene_, picture.width, PictureRow(picture, v));
  }

 private:
  struct Thing {
    double distance_m;
    std::variant<Solid, SeenStrand> what;
  };

  void add(double distance_m, Solid solid) {
    if (!solid.rect().empty()) things_.push_back({distance_m, std::move(solid)});
  }
  void add(double distance_m, SeenStrand strand) {
    if (!strand.rect().empty()) things_.push_back({distance_m, std::move(strand)});
  }

  void add_solids() {
    const auto distance = [&](const Eigen::Vector3d& ned_m) { return (ned_m - view_.position_ned_m).norm(); };
    constexpr double standing_m = 3;  // a person on the ground is no higher
    for (size_t i = 0; i < scene_.buckets.size(); ++i) {
      const Bucket& bucket = scene_.buckets[i];
      const double to_bucket = distance(bucket.rigid.position_ned_m);
      add(to_bucket, Solid::of(view_, bucket, motions_.bucket(i)));
      add(to_bucket - 1e-3, SeenStrand(view_, handle_strand(bucket), motions_.bucket(i)));
    }
    for (const Tyre& tyre : scene_.tyres) {
      const Eigen::Vector3d& at = tyre.rigid.position_ned_m;
      add(distance(at), Solid::of(view_, tyre, motions_.of_place(scene_, at, standing_m)));
    }
    for (const Capsule& capsule : scene_.capsules) {
      const Eigen::Vector3d middle = (capsule.from_ned_m + capsule.to_ned_m) / 2;
      add(distance(middle), Solid::of(view_, capsule, motions_.of_place(scene_, middle, standing_m)));
    }
  }

  void add_strands() {
    constexpr double lying_m = 0.3;  // higher, it hangs from the aircraft
    for (const Strand& strand : scene_.strands) {
      if (strand.points_ned_m.empty()) continue;
      const Eigen::Vector3d& end = strand.points_ned_m.back();
      add(0, SeenStrand(view_, strand, motions_.of_place(scene_, end, lying_m)));
    }
  }

  static void note_covered(const PlaneRow& row, std::vector<std::uint8_t>& covered) {
    for (int u = row.first; u < row.last; ++u)
      if (row.cover[static_cast<size_t>(u)] >= 1) covered[static_cast<size_t>(u)] = 1;
  }

  /// The ground where no deck hides it.
  void draw_ground(int v, const Textures& textures, Scratch& scratch, const PictureRow& row) const {
    const int width = view_.rays.width_px;
    std::fill(scratch.covered.begin(), scratch.covered.end(), std::uint8_t{0});
    for (const DeckLayer& deck : decks_)
      if (deck.meet(v, scratch.deck_row)) note_covered(scratch.deck_row, scratch.covered);
    const auto hidden = [&](int u) { return scratch.covered[static_cast<size_t>(u)] != 0; };
    std::fill_n(row.depth_m, width, 1e9F);
    for (int u = 0; u < width;) {
      while (u < width && hidden(u)) ++u;
      scratch.ground_row.v = v;
      scratch.ground_row.first = u;
      while (u < width && !hidden(u)) ++u;
      scratch.ground_row.last = u;
      if (scratch.ground_row.first < u) ground_.draw(textures, scratch.ground_row, row);
    }
  }

  const Scene& scene_;
  View view_;
  Motions motions_;
  GroundLayer ground_;
  std::vector<DeckLayer> decks_;  ///< the farthest first
  std::vector<Thing> things_;
};

}  // namespace

struct Renderer::Workspace {
  explicit Workspace(int threads) : workers(threads), scratch(static_cast<size_t>(workers.threads())) {}

  Workers workers;
  std::vector<Scratch> scratch;
  Textures textures = draw_textures();
  NoiseTile noise;
  std::optional<CameraModel> lens;
  LensRays rays;
  std::optional<ResponseTable> response;
  Picture picture;

  void prepare(const Scene& scene) {
    const CameraModel& wanted = scene.eye.lens;
    if (!lens || !same_rays(*lens, wanted)) rays = rays_of(wanted);
    if (!response || !response->is_for(wanted.response)) response.emplace(wanted.response);
    lens = wanted;
    picture.resize(rays.width_px, rays.height_px);
    for (Scratch& each : scratch) each.resize(rays.width_px);
  }

  /// Calls rows(first, last, scratch) for all rows of the picture.
  template <typename Rows>
  void in_pieces(const Rows& rows) {
    const int height = picture.height, pieces = (height + piece_rows - 1) / piece_rows;
    workers.share(pieces, [&](int piece, int worker) {
      const int first = piece * piece_rows;
      rows(first, std::min(first + piece_rows, height), scratch[static_cast<size_t>(worker)]);
    });
  }
};

Renderer::Renderer(int threads) : workspace_(std::make_unique<Workspace>(threads)) {}

Renderer::~Renderer() = default;

cv::Mat Renderer::render(const Scene& scene) {
  Workspace& w = *workspace_;
  w.prepare(scene);
  const Stage stage(scene, w.rays);
  w.in_pieces([&](int first, int last, Scratch& scratch) {
    stage.draw(first, last, w.textures, scratch, w.picture);
  });
  const Veil veil(scene, stage.view(), w.picture);
  const Darkroom darkroom{scene, w.rays, stage.motions(), w.picture, w.noise, *w.response, veil};
  cv::Mat bgr(w.picture.height, w.picture.width, CV_8UC3);
  w.in_pieces([&](int first, int last, Scratch& scratch) {
    develop_rows(darkroom, first, last, scratch.develop, bgr);
  });
  return bgr;
}

}  // namespace stevedore::world
