#include "sim_proc/world/workers.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace stevedore::world {

struct Workers::Pool {
  std::mutex mutex;
  std::condition_variable begun, ended;
  std::uint64_t round = 0;
  bool quit = false;
  int busy = 0;
  int pieces = 0;
  std::atomic<int> next_piece{0};
  const std::function<void(int, int)>* work = nullptr;
  std::vector<std::thread> threads;

  void take_pieces(int worker) {
    for (int piece = next_piece++; piece < pieces; piece = next_piece++) (*work)(piece, worker);
  }

  void run(int worker) {
    std::uint64_t done_round = 0;
    for (;;) {
      {
        std::unique_lock lock(mutex);
        begun.wait(lock, [&] { return quit || round != done_round; });
        if (quit) return;
        done_round = round;
      }
      take_pieces(worker);
      const std::lock_guard lock(mutex);
      if (--busy == 0) ended.notify_one();
    }
  }
};

Workers::Workers(int threads) : pool_(std::make_unique<Pool>()) {
  for (int worker = 1; worker < std::max(threads, 1); ++worker)
    pool_->threads.emplace_back([this, worker] { pool_->run(worker); });
}

Workers::~Workers() {
  {
    const std::lock_guard lock(pool_->mutex);
    pool_->quit = true;
  }
  pool_->begun.notify_all();
  for (std::thread& thread : pool_->threads) thread.join();
}

int Workers::threads() const {
  return static_cast<int>(pool_->threads.size()) + 1;
}

void Workers::share(int pieces, const std::function<void(int, int)>& work) {
  {
    const std::lock_guard lock(pool_->mutex);
    pool_->pieces = pieces;
    pool_->work = &work;
    pool_->next_piece = 0;
    pool_->busy = static_cast<int>(pool_->threads.size());
    ++pool_->round;
  }
  pool_->begun.notify_all();
  pool_->take_pieces(0);
  std::unique_lock lock(pool_->mutex);
  pool_->ended.wait(lock, [&] { return pool_->busy == 0; });
}

}  // namespace stevedore::world
