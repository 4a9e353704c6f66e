#include "sim_proc/render_thread.hpp"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "geometry/rectify.hpp"
#include "sim_proc/published_outline.hpp"
#include "sim_proc/world/renderer.hpp"

namespace stevedore {

struct RenderThread::Work {
  Work(int threads, const CameraModel& camera)
      : told(camera), maps(make_rectify_maps(camera)), renderer(threads), thread([this] { run(); }) {}
  ~Work() {
    {
      const std::lock_guard lock(mutex);
      stop = true;
    }
    changed.notify_all();
    thread.join();
  }
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;

  Picture draw(Exposure caught) {
    Picture drawn{caught.frame_seq, caught.utime, {}, std::move(caught.truth)};
    drawn.pixels = rectify(renderer.render(caught.scene), maps);
    for (world::CircleTruth& circle : drawn.truth.circles)
      circle.outline = published_outline(caught.scene, circle, told);
    return drawn;
  }

  void run() {
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [this] { return stop || exposure; });
      if (stop) return;
      Exposure next = *std::exchange(exposure, std::nullopt);
      lock.unlock();
      std::optional<Picture> drawn;
      std::exception_ptr why;
      try {
        drawn = draw(std::move(next));
      } catch (...) {
        why = std::current_exception();
      }
      lock.lock();
      picture = std::move(drawn);
      failure = why;
      ended.notify_all();
    }
  }

  const CameraModel told;
  const RectifyMaps maps;
  world::Renderer renderer;
  bool busy = false;  ///< of the thread that starts and takes
  std::mutex mutex;
  std::condition_variable changed, ended;
  bool stop = false;
  std::optional<Exposure> exposure;  ///< waits to be drawn
  std::optional<Picture> picture;    ///< waits to be taken
  std::exception_ptr failure;
  std::thread thread;  ///< last: it uses all the others
};

RenderThread::RenderThread(int threads, const CameraModel& told)
    : work_(std::make_unique<Work>(threads, told)) {}

RenderThread::~RenderThread() = default;

void RenderThread::warm_up(const world::Scene& scene) {
  work_->renderer.render(scene);  // in the caller's thread: its own has nothing to draw yet
}

bool RenderThread::is_busy() const {
  return work_->busy;
}

void RenderThread::start(Exposure exposure) {
  work_->busy = true;
  {
    const std::lock_guard lock(work_->mutex);
    work_->exposure = std::move(exposure);
  }
  work_->changed.notify_all();
}

std::optional<Picture> RenderThread::take() {
  const std::lock_guard lock(work_->mutex);
  if (work_->failure) std::rethrow_exception(std::exchange(work_->failure, nullptr));
  auto picture = std::exchange(work_->picture, std::nullopt);
  if (picture) work_->busy = false;
  return picture;
}

void RenderThread::wait() {
  std::unique_lock lock(work_->mutex);
  work_->ended.wait(lock, [this] { return work_->picture || work_->failure; });
}

}  // namespace stevedore
