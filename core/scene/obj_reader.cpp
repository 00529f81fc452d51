#include "core/scene/obj_reader.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <vector>

#include "core/scene/file_tokens.hpp"
#include "core/scene/surface_limits.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

constexpr std::array<std::string_view, 19> skipped_words = {
    "vt",     "vn",       "vp",       "g",     "o",          "s",         "mg",     "usemtl", "mtllib", "maplib",
    "usemap", "c_interp", "d_interp", "bevel", "shadow_obj", "trace_obj", "usemat", "l",      "p"};

/// A vertex named after those read so far; whether it comes is known at the end.
struct Forward {
  std::int64_t vertex = 0;  ///< the largest one, counted from 1
  std::size_t line = 0;
};

/// The vertex of a face's corner, counted from 0.
int read_corner(FileTokens& in, std::int64_t vertices, Forward& forward) {
  const std::string word = in.word("corner of face");
  std::int64_t index = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
  const bool sound = error == std::errc{} && (end == word.data() + word.size() || *end == '/') && index != 0 &&
                     index >= -vertices && index <= INT32_MAX;
  if (!sound)
    in.fail("corner of face", "found \"" + quoted_excerpt(word) + "\", allowed a vertex from 1, or from -1 to -" +
                                  std::to_string(vertices) + " back from the last, and / after it");
  if (index > vertices && index > forward.vertex) forward = {index, in.line()};
  return static_cast<int>(index > 0 ? index - 1 : vertices + index);
}

}  // namespace

TriangleSurface read_obj(const std::string& file, std::string_view text) {
  FileTokens in(file, text);
  std::vector<Eigen::Vector3d> points;
  std::vector<int> corners;
  Forward forward;
  TriangleSurface surface;
  while (!in.at_end()) {
    const std::string word = in.word("line");
    if (word[0] == '#') {
      in.skip_line();
    } else if (word == "v") {
      Eigen::Vector3d& point = points.emplace_back();
      for (int axis = 0; axis < 3; ++axis) {
        if (in.line_ends()) in.fail("v", "found " + std::to_string(axis) + " coordinates, allowed three");
        point[axis] = in.number("coordinate");
      }
      in.skip_line();  // a weight or a colour
    } else if (word == "f") {
      corners.clear();
      const auto vertices = static_cast<std::int64_t>(points.size());
      while (!in.line_ends()) corners.push_back(read_corner(in, vertices, forward));
      if (corners.size() < 3) in.fail("f", "found " + std::to_string(corners.size()) + " corners, allowed 3 or more");
      if (surface.triangles.size() + corners.size() > most_surface_triangles)
        in.fail("f", "found more than " + std::to_string(most_surface_triangles) + " triangles, allowed as many");
      for (std::size_t k = 2; k < corners.size(); ++k)
        surface.triangles.push_back({corners[0], corners[k - 1], corners[k]});
    } else if (std::find(skipped_words.begin(), skipped_words.end(), word) != skipped_words.end()) {
      while (!in.line_ends()) in.word("skipped");
    } else {
      in.fail("OBJ", "found \"" + quoted_excerpt(word) +
                         "\", allowed v, f, comments and what is skipped: vt, vn, g, o, " +
                         "s, usemtl, mtllib, l, p and the like");
    }
  }
  if (forward.vertex > static_cast<std::int64_t>(points.size()))
    in.fail_at(forward.line, "corner of face",
               "found vertex " + std::to_string(forward.vertex) + ", allowed 1 to " + std::to_string(points.size()));
  if (surface.triangles.empty()) in.fail("OBJ", "found no face, allowed one or more");
  surface.vertices.resize(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) surface.vertices.col(static_cast<Eigen::Index>(i)) = points[i];
  return surface;
}

}  // namespace finegauge
