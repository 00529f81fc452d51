#include "core/scene/stl_reader.hpp"

#include <algorithm>
#include <cstdint>

#include "core/scene/file_bytes.hpp"
#include "core/scene/file_tokens.hpp"
#include "core/scene/surface_repair.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

constexpr std::size_t header_bytes = 80, count_bytes = 4, triangle_bytes = 50;

std::uint64_t announced_triangles(std::string_view bytes) {
  std::uint64_t count = 0;
  for (std::size_t k = 0; k < count_bytes; ++k)
    count |= std::uint64_t{static_cast<unsigned char>(bytes[header_bytes + k])} << (8 * k);
  return count;
}

TriangleSurface surface_of(const std::vector<Eigen::Vector3d>& corners) {
  TriangleSurface surface;
  surface.vertices.resize(3, static_cast<Eigen::Index>(corners.size()));
  for (std::size_t i = 0; i < corners.size(); ++i) surface.vertices.col(static_cast<Eigen::Index>(i)) = corners[i];
  for (int i = 0; i < static_cast<int>(corners.size()); i += 3) surface.triangles.push_back({i, i + 1, i + 2});
  merge_equal_vertices(surface);
  return surface;
}

TriangleSurface read_binary(const std::string& file, std::string_view bytes) {
  FileBytes in(file, bytes, 0, false);
  in.skip(header_bytes, "header");
  const auto count = static_cast<std::size_t>(in.integer(ScalarType::uint32, "number of triangles", 0, UINT32_MAX));
  if (count == 0) in.fail("number of triangles", "found 0, allowed one or more");
  if (in.left() != count * triangle_bytes)
    in.fail("number of triangles", "found " + std::to_string(count) + ", which take " +
                                       std::to_string(count * triangle_bytes) + " bytes, and " +
                                       std::to_string(in.left()) + " bytes after it, allowed as many as it announces");
  std::vector<Eigen::Vector3d> corners;
  corners.reserve(3 * count);
  for (std::size_t t = 0; t < count; ++t) {
    in.skip(12, "normal");
    for (int corner = 0; corner < 3; ++corner) {
      Eigen::Vector3d& point = corners.emplace_back();
      for (int axis = 0; axis < 3; ++axis) point[axis] = in.number(ScalarType::float32, "coordinate");
    }
    in.skip(2, "attributes");
  }
  return surface_of(corners);
}

void expect_word(FileTokens& in, const std::string& allowed) {
  const std::string found = in.word(allowed);
  std::string lower = found;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (lower != allowed) in.fail("text STL", "found \"" + quoted_excerpt(found) + "\", allowed \"" + allowed + "\"");
}

/// After "facet" to "endfacet".
void read_facet(FileTokens& in, std::vector<Eigen::Vector3d>& corners) {
  expect_word(in, "normal");
  for (int axis = 0; axis < 3; ++axis) in.word("normal");
  expect_word(in, "outer");
  expect_word(in, "loop");
  for (int corner = 0; corner < 3; ++corner) {
    expect_word(in, "vertex");
    Eigen::Vector3d& point = corners.emplace_back();
    for (int axis = 0; axis < 3; ++axis) point[axis] = in.number("coordinate");
  }
  expect_word(in, "endloop");
  expect_word(in, "endfacet");
}

TriangleSurface read_text(const std::string& file, std::string_view text) {
  FileTokens in(file, text);
  std::vector<Eigen::Vector3d> corners;
  while (!in.at_end()) {
    expect_word(in, "solid");
    in.skip_line();
    for (;;) {
      const std::string found = in.word("endsolid");
      if (found == "endsolid" || found == "ENDSOLID") break;
      if (found != "facet" && found != "FACET")
        in.fail("text STL", "found \"" + quoted_excerpt(found) + "\", allowed \"facet\" or \"endsolid\"");
      read_facet(in, corners);
    }
    in.skip_line();
  }
  if (corners.empty()) in.fail("text STL", "found no facet, allowed one or more");
  return surface_of(corners);
}

}  // namespace

bool is_binary_stl(std::string_view bytes) {
  const std::size_t first = header_bytes + count_bytes;
  return bytes.size() >= first && bytes.size() - first == announced_triangles(bytes) * triangle_bytes;
}

TriangleSurface read_stl(const std::string& file, std::string_view bytes) {
  // The header of a binary file may begin with "solid" too; a text has no byte 0.
  const bool text = !is_binary_stl(bytes) && bytes.substr(0, 1000).find('\0') == std::string_view::npos &&
                    (bytes.starts_with("solid") || bytes.starts_with("SOLID") || bytes.size() < header_bytes);
  return text ? read_text(file, bytes) : read_binary(file, bytes);
}

}  // namespace finegauge
