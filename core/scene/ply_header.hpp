#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/file_bytes.hpp"

namespace finegauge {

struct PlyProperty {
  std::string name;
  ScalarType type;                       ///< of the value, or of each entry of the list
  std::optional<ScalarType> list_count;  ///< a list: whole, of its length
};

struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::size_t line = 0;
  std::vector<PlyProperty> properties;
};

enum class PlyEncoding { text, little_endian, big_endian };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::text;
  std::vector<PlyElement> elements;  ///< in the order of the data
  std::size_t lines = 0;
  std::size_t bytes = 0;  ///< up to the data
};

/// Throws SceneError "FILE:LINE: ...".
PlyHeader read_ply_header(const std::string& file, std::string_view bytes);

}  // namespace finegauge
