#include "camera_proc/source_thread.hpp"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

namespace stevedore {
namespace {

using namespace std::chrono_literals;

// Owned by the thread and by the source in front of it: whichever lives longer.
struct Mailbox {
  std::mutex mutex;
  std::condition_variable changed;
  bool stop = false;
  bool ended = false;
  Grab outcome = Grab::none;  // of the newest grab not fetched yet
  cv::Mat image;
  std::int64_t capture_utime = 0;
  std::string fault;
  std::int64_t superseded = 0;  // frames that nobody fetched before the next one came
};

void post(Mailbox& box, Grab outcome, cv::Mat image, std::int64_t capture_utime, std::string fault) {
  {
    const std::lock_guard lock(box.mutex);
    if (box.outcome == Grab::frame) ++box.superseded;
    box.outcome = outcome;
    box.image = std::move(image);
    box.capture_utime = capture_utime;
    box.fault = std::move(fault);
  }
  box.changed.notify_all();
}

bool stopped(Mailbox& box) {
  const std::lock_guard lock(box.mutex);
  return box.stop;
}

// Opens and reads until told to stop or until the source fails or ends: that is its last word.
void read_device(const Opener& open, Mailbox& box) {
  std::string fault;
  const std::unique_ptr<FrameSource> source = open(fault);
  if (!source) return post(box, Grab::failed, {}, 0, fault);
  while (!stopped(box)) {
    cv::Mat image;
    std::int64_t capture_utime = 0;
    const Grab outcome = source->grab(image, capture_utime);
    if (outcome == Grab::none) continue;
    post(box, outcome, std::move(image), capture_utime, source->fault());
    if (outcome != Grab::frame) return;
  }
}

void run_thread(const Opener& open, const std::shared_ptr<Mailbox>& box) {
  try {
    read_device(open, *box);
  } catch (const std::exception& error) {
    post(*box, Grab::failed, {}, 0, error.what());
  }
  {
    const std::lock_guard lock(box->mutex);
    box->ended = true;
  }
  box->changed.notify_all();
}

class ThreadedSource : public FrameSource {
 public:
  ThreadedSource(const Opener& open, std::shared_ptr<Mailbox> box)
      : box_(std::move(box)), thread_([open, mailbox = box_] { run_thread(open, mailbox); }) {}

  ~ThreadedSource() override {
    std::unique_lock lock(box_->mutex);
    box_->stop = true;
    const bool ended = box_->changed.wait_for(lock, 500ms, [this] { return box_->ended; });
    lock.unlock();
    ended ? thread_.join() : thread_.detach();
  }
  ThreadedSource(const ThreadedSource&) = delete;
  ThreadedSource& operator=(const ThreadedSource&) = delete;

  Grab grab(cv::Mat& image, std::int64_t& capture_utime) override {
    std::unique_lock lock(box_->mutex);
    box_->changed.wait_for(lock, 50ms, [this] { return box_->outcome != Grab::none; });
    image = std::move(box_->image);
    box_->image = cv::Mat();
    capture_utime = box_->capture_utime;
    fault_ = box_->fault;
    const bool last_word = box_->outcome == Grab::failed || box_->outcome == Grab::end;
    return last_word ? box_->outcome : std::exchange(box_->outcome, Grab::none);
  }
  [[nodiscard]] std::string fault() const override { return fault_; }
  [[nodiscard]] bool is_live() const override { return true; }
  std::int64_t take_superseded() override {
    const std::lock_guard lock(box_->mutex);
    return std::exchange(box_->superseded, 0);
  }

 private:
  std::shared_ptr<Mailbox> box_;
  std::thread thread_;
  std::string fault_;
};

}  // namespace

Opener threaded(Opener open) {
  // Expired once the previous thread is gone.
  return [open = std::move(open),
          previous = std::weak_ptr<Mailbox>()](std::string& fault) mutable -> std::unique_ptr<FrameSource> {
    if (!previous.expired()) {
      fault = "the driver still blocks since the device was lost";
      return nullptr;
    }
    auto box = std::make_shared<Mailbox>();
    previous = box;
    return std::make_unique<ThreadedSource>(open, std::move(box));
  };
}

}  // namespace stevedore
