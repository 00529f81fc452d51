#include "core/scene/gmsh_reader.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "core/scene/gmsh_contents.hpp"
#include "core/scene/imported_mesh.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {

using namespace gmsh_type;

namespace {

constexpr std::uintmax_t mesh_size_limit = std::uintmax_t{1} << 30;

using FaceNodes = std::array<int, 4>;

void read_surfaces(const FileTokens& in, const GmshContents& contents, const std::vector<int>& number_of,
                   BaseMesh& mesh) {
  const auto in_no_group = [](const GmshElement& face) { return face.groups.empty(); };
  if (std::all_of(contents.faces.begin(), contents.faces.end(), in_no_group)) return;
  const int corners = face_corner_count(mesh.shape);
  std::map<FaceNodes, BaseFace> boundary;
  for (const BaseFace face : boundary_faces(mesh)) {
    FaceNodes nodes = {-1, -1, -1, -1};
    for (int k = 0; k < corners; ++k)
      nodes[static_cast<std::size_t>(k)] = mesh.cells[face.cell][face_corners(mesh.shape, face.face)[k]];
    std::sort(nodes.begin(), nodes.end());
    boundary.emplace(nodes, face);
  }
  std::map<std::string, std::set<BaseFace>> surfaces;
  for (const GmshElement& element : contents.faces) {
    if (in_no_group(element)) continue;
    const int count = element.type == triangle ? 3 : 4;
    FaceNodes nodes = {-1, -1, -1, -1};
    for (int k = 0; k < count; ++k) nodes[static_cast<std::size_t>(k)] = number_of[gmsh_node(in, contents, element, k)];
    std::sort(nodes.begin(), nodes.end());
    const auto found = count == corners ? boundary.find(nodes) : boundary.end();
    if (found == boundary.end())
      in.fail_at(element.line, "element " + std::to_string(element.tag),
                 "found a face of a physical surface that is not on the boundary of the cells, allowed boundary faces");
    for (const std::int64_t group : element.groups) {
      const auto name = contents.surface_names.find(group);
      surfaces[name == contents.surface_names.end() ? "physical_" + std::to_string(group) : name->second].insert(
          found->second);
    }
  }
  for (const auto& [name, faces] : surfaces) mesh.surfaces[name].assign(faces.begin(), faces.end());
}

}  // namespace

BaseMesh read_gmsh(const std::filesystem::path& file) {
  const std::string text = read_text_file(file, mesh_size_limit);
  FileTokens in(file.string(), text);
  const GmshContents contents = read_gmsh_contents(in);
  if (contents.cells.empty())
    in.fail_at(contents.elements_line, "$Elements", "found no hexahedra and no tetrahedra, allowed one or more");

  BaseMesh mesh;
  mesh.shape = contents.cells.front().type == hexahedron ? CellShape::hexahedron : CellShape::tetrahedron;
  const int corners = corner_count(mesh.shape);
  std::vector<std::size_t> corner_positions;  // in contents.nodes, of all cells
  std::vector<int> number_of(contents.nodes.size(), -1);
  for (const GmshElement& cell : contents.cells)
    for (int k = 0; k < corners; ++k) {
      corner_positions.push_back(gmsh_node(in, contents, cell, k));
      number_of[corner_positions.back()] = 0;
    }
  int node_count = 0;
  for (int& number : number_of)
    if (number == 0) number = node_count++;
  mesh.nodes.resize(3, node_count);
  for (std::size_t i = 0; i < contents.nodes.size(); ++i)
    if (number_of[i] >= 0) mesh.nodes.col(number_of[i]) = contents.nodes[i].position;

  for (std::size_t c = 0; c < contents.cells.size(); ++c) {
    std::array<int, 8> listed{};
    for (int k = 0; k < corners; ++k)
      listed[static_cast<std::size_t>(k)] = number_of[corner_positions[c * static_cast<std::size_t>(corners) + k]];
    mesh.cells.push_back(
        corners_from_file_order(mesh.shape, std::span(listed.data(), static_cast<std::size_t>(corners))));
    const std::string defect = cell_defect(mesh.shape, mesh.nodes, mesh.cells.back());
    if (!defect.empty()) in.fail_at(contents.cells[c].line, "element " + std::to_string(contents.cells[c].tag), defect);
  }
  if (const ConnectionDefect defect = connection_defect(mesh); defect.cell >= 0) {
    const GmshElement& element = contents.cells[static_cast<std::size_t>(defect.cell)];
    in.fail_at(element.line, "element " + std::to_string(element.tag), defect.words);
  }
  read_surfaces(in, contents, number_of, mesh);
  return mesh;
}

}  // namespace finegauge
