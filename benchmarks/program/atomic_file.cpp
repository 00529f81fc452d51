#include "benchmarks/program/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>

namespace finegauge {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, int error) {
  throw std::runtime_error("cannot write " + file.string() + ": " + std::strerror(error));
}

bool write_all(int descriptor, std::string_view content) {
  while (!content.empty()) {
    const ssize_t written = ::write(descriptor, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  // Without this a power cut after the rename could leave a file that is complete in name only.
  return ::fsync(descriptor) == 0 || errno == EINVAL;
}

}  // namespace

std::filesystem::path temporary_beside(const std::filesystem::path& file) {
  return file.parent_path() / ("." + file.filename().string() + "." + std::to_string(::getpid()) + ".part");
}

void write_file_atomically(const std::filesystem::path& file, std::string_view content) {
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  if (error) fail(file, error.value());

  const std::filesystem::path temporary = temporary_beside(file);
  const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor < 0) fail(file, errno);
  const bool written = write_all(descriptor, content);
  const int write_error = errno;
  const bool closed = ::close(descriptor) == 0;
  if (!written || !closed) {
    const int reason = written ? errno : write_error;
    ::unlink(temporary.c_str());
    fail(file, reason);
  }
  if (std::rename(temporary.c_str(), file.c_str()) != 0) {
    const int reason = errno;
    ::unlink(temporary.c_str());
    fail(file, reason);
  }
}

}  // namespace finegauge
