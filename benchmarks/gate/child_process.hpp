#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace finegauge {

/// How a program ended that was run to its end.
struct ProcessEnd {
  int exit_code = -1;        ///< -1 when a signal ended it
  int signal = 0;            ///< that ended it; 0: none
  bool timed_out = false;    ///< it was ended for taking too long
  bool interrupted = false;  ///< it was ended because this program was asked to stop
  double seconds = 0.0;
};

/// Runs a program, found by its path or on PATH, without a shell; standard input is empty, output and errors go to
/// files. A program that cannot be started has exit code 127.
ProcessEnd run_process(const std::vector<std::string>& words, const std::filesystem::path& out,
                       const std::filesystem::path& err, double seconds_allowed);

/// "exit code 2", "signal 11 (Segmentation fault)", "no end within 600 s".
std::string describe(const ProcessEnd& end, double seconds_allowed);

/// A folder of this process below the system's temporary one, removed with all in it at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace finegauge
