#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace finegauge {

enum class ScalarType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
int byte_count(ScalarType type);
bool is_whole(ScalarType type);

/// The bytes of a binary file one scalar after another, each checked as it is taken; remembers the place for messages.
class FileBytes {
 public:
  /// All bytes of the file, which must outlive this value; taken from `start` on.
  FileBytes(std::string file, std::string_view bytes, std::size_t start, bool big_endian)
      : file_(std::move(file)), bytes_(bytes), next_(start), place_(start), big_endian_(big_endian) {}

  double number(ScalarType type, const std::string& field);  ///< finite
  std::int64_t integer(ScalarType type, const std::string& field, std::int64_t low, std::int64_t high);
  void skip(std::size_t bytes, const std::string& field);
  std::size_t left() const { return bytes_.size() - next_; }

  /// Names the byte at which the scalar taken last begins, counted from 0.
  [[noreturn]] void fail(const std::string& field, const std::string& what) const;

 private:
  std::uint64_t take(int count, const std::string& field);

  std::string file_;
  std::string_view bytes_;
  std::size_t next_, place_;
  bool big_endian_;
};

}  // namespace finegauge
