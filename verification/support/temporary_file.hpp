#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace finegauge {

/// A file in the system's temporary directory that lives as long as this value; unlike for each process.
class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& text)
      : path_(std::filesystem::temp_directory_path() / ("finegauge_" + std::to_string(::getpid()) + "_" + name)) {
    std::ofstream(path_, std::ios::binary) << text;
  }
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The reference data of the source tree that the tests were compiled from.
inline std::filesystem::path reference_data() {
  return std::filesystem::path(__FILE__).parent_path().parent_path().parent_path() / "reference_data";
}

}  // namespace finegauge
