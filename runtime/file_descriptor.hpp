// A file descriptor that is closed.
#pragma once

#include <unistd.h>

namespace stevedore {

class FileDescriptor {
 public:
  explicit FileDescriptor(int fd) : fd_(fd) {}  ///< negative: none
  ~FileDescriptor() {
    if (fd_ >= 0) close(fd_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

}  // namespace stevedore
