// Threads that share out numbered pieces of work.
#pragma once

#include <functional>
#include <memory>

namespace stevedore::world {

class Workers {
 public:
  /// threads: how many work at a time, the caller's included; at least 1.
  explicit Workers(int threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// Calls work(piece, worker) once for each piece of 0..pieces-1, worker in 0..threads-1 for scratch memory;
  /// returns when all are done. work must not throw.
  void share(int pieces, const std::function<void(int piece, int worker)>& work);
  [[nodiscard]] int threads() const;

 private:
  struct Pool;
  std::unique_ptr<Pool> pool_;
};

}  // namespace stevedore::world
