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
#include <cstdio>
#include <cstring>
#include <exception>
#include <stdexcept>

#include "core/scene/scene_error.hpp"

namespace finegauge {
namespace {

constexpr char returned = 'r', threw = 't', refused = 's';

/// Wall time after which work counts as waiting for something that never comes, whoever else has the processor.
constexpr double wall_per_processor_second = 20.0;

ApartResult too_long(double seconds, const char* of_what) {
  std::array<char, 64> text;
  std::snprintf(text.data(), text.size(), "no end within %g s%s", seconds, of_what);
  return {ApartResult::End::too_long, {}, text.data()};
}

void write_all(int file, const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t wrote = ::write(file, bytes.data() + done, bytes.size() - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) ::_exit(1);  // nobody reads any more
    done += static_cast<std::size_t>(wrote);
  }
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

[[noreturn]] void compute_and_leave(const std::function<std::string()>& compute, int to) {
  std::string bytes;
  try {
    bytes = returned + compute();
  } catch (const SceneError& error) {
    bytes = refused + std::string(error.what());
  } catch (const std::exception& error) {
    bytes = threw + std::string(error.what());
  } catch (...) {
    bytes = threw + std::string("an unknown exception");
  }
  write_all(to, bytes);
  ::_exit(0);
}

}  // namespace

void end_openmp_threads() {
  constexpr int hard = 2;  // omp_pause_hard, of a library that may not be there
  if (auto* pause = reinterpret_cast<int (*)(int)>(::dlsym(RTLD_DEFAULT, "omp_pause_resource_all"))) pause(hard);
}

void end_with_parent(int parent) {
#ifdef __linux__
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  if (::getppid() != parent) ::_exit(1);  // gone before the line above
}

ApartResult run_apart(const std::function<std::string()>& compute, double seconds,
                      const std::function<bool()>& interrupted) {
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
  std::string bytes;
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
    }
    stopped = interrupted();
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
  if (WEXITSTATUS(status) != 0 || bytes.empty())
    return {End::crashed, {}, "the process ended by itself, code " + std::to_string(WEXITSTATUS(status))};
  const char how = bytes.front();
  bytes.erase(bytes.begin());
  if (how == refused) return {End::refused, {}, bytes};
  if (how == threw) return {End::crashed, {}, bytes};
  return {End::done, std::move(bytes), {}};
}

}  // namespace finegauge
