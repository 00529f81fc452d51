#include "core/scene/gmsh_surface.hpp"

#include "core/scene/gmsh_contents.hpp"
#include "core/scene/surface_edges.hpp"

namespace finegauge {

TriangleSurface read_gmsh_surface(const std::string& file, std::string_view text) {
  FileTokens in(file, text);
  const GmshContents contents = read_gmsh_contents(in);
  TriangleSurface surface;
  surface.vertices.resize(3, static_cast<Eigen::Index>(contents.nodes.size()));
  for (std::size_t i = 0; i < contents.nodes.size(); ++i)
    surface.vertices.col(static_cast<Eigen::Index>(i)) = contents.nodes[i].position;
  for (const GmshElement& face : contents.faces) {
    if (face.type != gmsh_type::triangle)
      in.fail_at(face.line, "element " + std::to_string(face.tag), "found a quadrangle (3), allowed triangles (2)");
    std::array<int, 3>& triangle = surface.triangles.emplace_back();
    for (int k = 0; k < 3; ++k)
      triangle[static_cast<std::size_t>(k)] = static_cast<int>(gmsh_node(in, contents, face, k));
  }
  if (surface.triangles.empty())
    in.fail_at(contents.elements_line, "$Elements", "found no triangles (2), allowed one or more");
  orient_as_neighbours(surface.triangles);
  return surface;
}

}  // namespace finegauge
