#include "benchmarks/gate/child_process.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "benchmarks/program/interrupt.hpp"

namespace finegauge {
namespace {

constexpr int cannot_start = 127;  // as shells have it

/// Between fork and exec, where only system calls are safe.
[[noreturn]] void become(const std::vector<char*>& arguments, const char* out, const char* err) {
  const int in = ::open("/dev/null", O_RDONLY);
  const int to_out = ::open(out, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  const int to_err = ::open(err, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (in < 0 || to_out < 0 || to_err < 0) ::_exit(cannot_start);
  ::dup2(in, 0);
  ::dup2(to_out, 1);
  ::dup2(to_err, 2);
  ::execvp(arguments[0], arguments.data());
  ::_exit(cannot_start);
}

}  // namespace

ProcessEnd run_process(const std::vector<std::string>& words, const std::filesystem::path& out,
                       const std::filesystem::path& err, double seconds_allowed) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));  // exec's signature
  arguments.push_back(nullptr);
  const std::string out_name = out.string(), err_name = err.string();
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error(std::string("no further process: ") + std::strerror(errno));
  if (child == 0) become(arguments, out_name.c_str(), err_name.c_str());

  ProcessEnd end;
  const auto spent = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  int status = 0;
  // Asked a few hundred times a second: what is timed is timed by the child itself, and must not wait for us.
  for (pid_t ended = 0; ended == 0;) {
    ended = ::waitpid(child, &status, WNOHANG);
    if (ended < 0) {
      if (errno != EINTR) throw std::runtime_error(std::string("waitpid: ") + std::strerror(errno));
      ended = 0;
    }
    if (ended != 0) continue;
    end.timed_out = end.timed_out || spent() > seconds_allowed;
    end.interrupted = end.interrupted || interrupt_signal() != 0;
    if (end.timed_out || end.interrupted) ::kill(child, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  }
  end.seconds = spent();
  if (WIFEXITED(status)) end.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  return end;
}

std::string describe(const ProcessEnd& end, double seconds_allowed) {
  if (end.interrupted) return "interrupted";
  if (end.timed_out) return "no end within " + std::to_string(static_cast<int>(seconds_allowed)) + " s";
  if (end.signal != 0) return "signal " + std::to_string(end.signal) + " (" + ::strsignal(end.signal) + ")";
  return "exit code " + std::to_string(end.exit_code);
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "finegauge_gate_XXXXXX").string();
  if (!::mkdtemp(name.data())) throw std::runtime_error(name + ": " + std::strerror(errno));
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;  // what is left in a temporary folder harms nobody
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace finegauge
