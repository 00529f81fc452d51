#pragma once

#include <sanitizer/allocator_interface.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "core/scene/scene_error.hpp"

namespace finegauge {

/// What the fuzzer keeps as an input that breaks a promise.
[[noreturn]] inline void report_finding(const std::string& words) {
  std::fprintf(stderr, "finding: %s\n", words.c_str());
  std::abort();
}

/// A folder of this process in the temporary directory: the readers take files by name, as a user gives them.
class FuzzFolder {
 public:
  FuzzFolder() : path_(std::filesystem::temp_directory_path() / ("finegauge_fuzz_" + std::to_string(::getpid()))) {
    std::filesystem::create_directory(path_);
  }
  ~FuzzFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  FuzzFolder(const FuzzFolder&) = delete;
  FuzzFolder& operator=(const FuzzFolder&) = delete;

  std::filesystem::path write(const std::string& name, std::string_view bytes) const {
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return path_ / name;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// The most that was on the heap at once since begin(), of what was put there since. Counted by the sanitizer.
class HeapPeak {
 public:
  static void begin() {
    static const int installed = __sanitizer_install_malloc_and_free_hooks(add, remove);
    if (installed == 0) report_finding("the sanitizer takes no hooks, so that memory is not watched");
    live_ = peak_ = 0;
  }
  static std::int64_t bytes() { return peak_; }

 private:
  static void add(const volatile void*, std::size_t size) {
    live_ += static_cast<std::int64_t>(size);
    if (live_ > peak_) peak_ = live_;
  }
  static void remove(const volatile void* block) {
    if (block != nullptr) live_ -= static_cast<std::int64_t>(__sanitizer_get_allocated_size(block));
  }
  static inline std::int64_t live_ = 0, peak_ = 0;
};

/// Storage grows with what was read, never with what a file announces: a byte of a list becomes at most some 50 bytes
/// of its entries, three times while a vector grows, and of a mesh the faces of its cells come on top.
inline void check_memory(std::int64_t peak, std::size_t file_size) {
  constexpr std::int64_t fixed = std::int64_t{1} << 20, per_byte = 200;
  if (peak > fixed + per_byte * static_cast<std::int64_t>(file_size))
    report_finding("a file of " + std::to_string(file_size) + " bytes took " + std::to_string(peak) + " on the heap");
}

/// Calls `read`; true when it returns, false when it refuses as promised: a SceneError whose message begins with a file
/// of the folder, or with the override, and is one line that a terminal shows as it is. Other exceptions are left to
/// end the program where they are thrown.
template <class Read>
bool accepts(const FuzzFolder& folder, const Read& read) {
  try {
    read();
    return true;
  } catch (const SceneError& error) {
    constexpr std::size_t fewest_words = 10;
    const std::string message = error.what(), in_folder = folder.path().string() + "/", by_override = "--set ";
    const std::string& begin = message.starts_with(by_override) ? by_override : in_folder;
    if (!message.starts_with(begin)) report_finding("a refusal that names no file: \"" + message + "\"");
    if (message.size() < begin.size() + fewest_words) report_finding("a refusal without words: \"" + message + "\"");
    for (const char c : message)
      if (static_cast<unsigned char>(c) < ' ' || c == '\x7f')
        report_finding("a refusal with control characters: \"" + message + "\"");
    return false;
  }
}

}  // namespace finegauge
