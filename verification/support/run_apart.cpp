#include "verification/support/run_apart.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/scene/scene_error.hpp"

namespace finegauge {
namespace {

// A message is its kind, its length and its bytes.
constexpr char said = 'm', returned = 'r', threw = 't', refused = 's';
constexpr std::size_t header_size = 1 + sizeof(std::uint64_t);

/// Wall time after which work counts as waiting for something that never comes, whoever else has the processor.
constexpr double wall_per_processor_second = 20.0;

ApartResult too_long(double seconds, const char* of_what) {
  std::array<char, 64> text;
  std::snprintf(text.data(), text.size(), "no end within %g s%s", seconds, of_what);
  return {ApartResult::End::too_long, {}, text.data()};
}

void write_message(int file, char kind, const std::string& text) {
  std::string bytes(header_size, kind);
  const std::uint64_t length = text.size();
  std::memcpy(bytes.data() + 1, &length, sizeof length);
  bytes += text;
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t wrote = ::write(file, bytes.data() + done, bytes.size() - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) ::_exit(1);  // nobody reads any more
    done += static_cast<std::size_t>(wrote);
  }
}

struct Message {
  char kind;
  std::string text;
};

/// Takes the first message out of what came, if it is whole.
std::optional<Message> next_message(std::string& bytes) {
  if (bytes.size() < header_size) return {};
  std::uint64_t length = 0;
  std::memcpy(&length, bytes.data() + 1, sizeof length);
  if (bytes.size() - header_size < length) return {};
  Message message{bytes.front(), bytes.substr(header_size, length)};
  bytes.erase(0, header_size + length);
  return message;
}

/// Of this process from here on; whole seconds, at least one.
void limit_processor_time(double seconds) {
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);  // a run that takes too long is no crash to look into
  if (!(seconds < 1e9)) return;
  const auto whole = static_cast<rlim_t>(std::max(1.0, std::ceil(seconds)));
  const rlimit limit{whole, whole + 1};
  ::setrlimit(RLIMIT_CPU, &limit);  // the system sends SIGXCPU
}

[[noreturn]] void compute_and_leave(const std::function<std::string(const Say&)>& compute, int to) {
  try {
    write_message(to, returned, compute([to](const std::string& text) { write_message(to, said, text); }));
  } catch (const SceneError& error) {
    write_message(to, refused, error.what());
  } catch (const std::exception& error) {
    write_message(to, threw, error.what());
  } catch (...) {
    write_message(to, threw, "an unknown exception");
  }
  ::_exit(0);
}

/// In a fork: ends it when `parent`, which must be what made it, is no more. Where the system has no such service (only
/// Linux does) nothing.
void end_with_parent(int parent) {
#ifdef __linux__
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  if (::getppid() != parent) ::_exit(1);  // gone before the line above
}

}  // namespace

void end_openmp_threads() {
  constexpr int hard = 2;  // omp_pause_hard, of a library that may not be there
  if (auto* pause = reinterpret_cast<int (*)(int)>(::dlsym(RTLD_DEFAULT, "omp_pause_resource_all"))) pause(hard);
}

ApartResult run_apart(const std::function<std::string()>& compute, double seconds,
                      const std::function<bool()>& interrupted) {
  ApartOptions options;
  options.seconds = seconds;
  options.interrupted = interrupted;
  return run_apart([&](const Say&) { return compute(); }, options);
}

ApartResult run_apart(const std::function<std::string(const Say&)>& compute, const ApartOptions& options) {
  const double seconds = options.seconds;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(std::string("no pipe: ") + std::strerror(errno));
  end_openmp_threads();
  const pid_t parent = ::getpid(), child = ::fork();
  if (child < 0) {
    const std::string why = std::strerror(errno);
    ::close(ends[0]);
    ::close(ends[1]);
    throw std::runtime_error("no further process: " + why);
  }
  if (child == 0) {
    ::close(ends[0]);  // else what it writes would never fail, and fill the pipe, when nobody reads any more
    end_with_parent(parent);
    limit_processor_time(seconds);
    compute_and_leave(compute, ends[1]);
  }
  ::close(ends[1]);
  std::string bytes;  // that came and are no whole message yet
  std::optional<Message> last;
  bool ended = false, stopped = false;
  const auto start = std::chrono::steady_clock::now();
  const auto spent = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  while (!ended && !stopped && spent() < wall_per_processor_second * seconds) {
    pollfd wait{ends[0], POLLIN, 0};
    constexpr int milliseconds = 100;
    if (::poll(&wait, 1, milliseconds) > 0) {
      std::array<char, 65536> buffer;
      const ssize_t read = ::read(ends[0], buffer.data(), buffer.size());
      if (read > 0) bytes.append(buffer.data(), static_cast<std::size_t>(read));
      ended = read == 0;
      for (std::optional<Message> message = next_message(bytes); message; message = next_message(bytes)) {
        if (message->kind == said)
          options.heard(std::move(message->text));
        else
          last = std::move(message);
      }
    }
    stopped = options.interrupted();
  }
  if (!ended) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  ::close(ends[0]);
  using End = ApartResult::End;
  if (!ended) {
    if (stopped) return {End::stopped, {}, "stopped"};
    return too_long(wall_per_processor_second * seconds, "");
  }
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) return too_long(seconds, " of processor time");
  if (WIFSIGNALED(status)) return {End::crashed, {}, std::string("a crash: ") + ::strsignal(WTERMSIG(status))};
  if (WEXITSTATUS(status) != 0 || !last)
    return {End::crashed, {}, "the process ended by itself, code " + std::to_string(WEXITSTATUS(status))};
  if (last->kind == refused) return {End::refused, {}, last->text};
  if (last->kind == threw) return {End::crashed, {}, last->text};
  return {End::done, std::move(last->text), {}};
}

}  // namespace finegauge
