#include "core/scene/surface_reader.hpp"

#include <algorithm>
#include <string>

#include "core/scene/gmsh_surface.hpp"
#include "core/scene/obj_reader.hpp"
#include "core/scene/ply_reader.hpp"
#include "core/scene/scene_error.hpp"
#include "core/scene/stl_reader.hpp"
#include "core/scene/surface_limits.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension;
}

}  // namespace

TriangleSurface read_surface(const std::filesystem::path& file) {
  const std::string bytes = read_text_file(file, surface_size_limit);
  const std::string name = file.string(), extension = lower_extension(file);
  if (bytes.starts_with("ply\n") || bytes.starts_with("ply\r\n")) return read_ply(name, bytes);
  if (bytes.starts_with("$MeshFormat")) return read_gmsh_surface(name, bytes);
  if (is_binary_stl(bytes)) return read_stl(name, bytes);
  if (extension == ".obj") return read_obj(name, bytes);
  if (extension == ".stl" || bytes.starts_with("solid")) return read_stl(name, bytes);
  if (extension == ".ply") return read_ply(name, bytes);
  if (extension == ".msh") return read_gmsh_surface(name, bytes);
  throw SceneError(name + ":1: surface: found \"" + quoted_excerpt(bytes.substr(0, 200), 20) +
                   "\", allowed STL, PLY or gmsh by content or extension (.stl, .ply, .msh), OBJ by extension (.obj)");
}

}  // namespace finegauge
