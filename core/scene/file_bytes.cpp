#include "core/scene/file_bytes.hpp"

#include <bit>
#include <cmath>

#include "core/scene/scene_error.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {

int byte_count(ScalarType type) {
  switch (type) {
    case ScalarType::int8:
    case ScalarType::uint8:
      return 1;
    case ScalarType::int16:
    case ScalarType::uint16:
      return 2;
    case ScalarType::int32:
    case ScalarType::uint32:
    case ScalarType::float32:
      return 4;
    case ScalarType::float64:
      break;
  }
  return 8;
}

bool is_whole(ScalarType type) { return type != ScalarType::float32 && type != ScalarType::float64; }

void FileBytes::fail(const std::string& field, const std::string& what) const {
  throw SceneError(file_ + ": byte " + std::to_string(place_) + ": " + quoted_excerpt(field) + ": " + what);
}

void FileBytes::skip(std::size_t bytes, const std::string& field) {
  place_ = next_;
  if (bytes > left()) fail(field, "found the end of the file");
  next_ += bytes;
}

std::uint64_t FileBytes::take(int count, const std::string& field) {
  skip(static_cast<std::size_t>(count), field);
  std::uint64_t value = 0;
  for (int k = 0; k < count; ++k) {
    const auto byte = static_cast<unsigned char>(bytes_[place_ + static_cast<std::size_t>(k)]);
    value |= std::uint64_t{byte} << (8 * (big_endian_ ? count - 1 - k : k));
  }
  return value;
}

std::int64_t FileBytes::integer(ScalarType type, const std::string& field, std::int64_t low, std::int64_t high) {
  const int count = byte_count(type);
  auto value = static_cast<std::int64_t>(take(count, field));
  const bool has_sign = type == ScalarType::int8 || type == ScalarType::int16 || type == ScalarType::int32;
  if (has_sign && value >> (8 * count - 1) != 0) value -= std::int64_t{1} << (8 * count);
  if (value < low || value > high)
    fail(field, "found " + std::to_string(value) + ", allowed a whole number in [" + std::to_string(low) + ", " +
                    std::to_string(high) + "]");
  return value;
}

double FileBytes::number(ScalarType type, const std::string& field) {
  if (is_whole(type)) return static_cast<double>(integer(type, field, INT32_MIN, UINT32_MAX));
  const double value = type == ScalarType::float32
                           ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(take(4, field))))
                           : std::bit_cast<double>(take(8, field));
  if (!std::isfinite(value)) fail(field, "found " + std::to_string(value) + ", allowed a finite number");
  return value;
}

}  // namespace finegauge
