#include "core/scene/geometry_reader.hpp"

#include <cstdint>
#include <utility>

#include "core/scene/gmsh_reader.hpp"
#include "core/scene/imported_mesh.hpp"
#include "core/scene/organ_reader.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

constexpr std::int64_t most_box_cells = 4'000'000;

BoxMeshOptions read_box(const SectionReader& reader) {
  BoxMeshOptions box;
  box.origin = reader.vector("origin");
  box.size = reader.vector("size");
  box.cells = reader.integers3("cells");
  box.shape = reader.text("shape") == "hexahedron" ? CellShape::hexahedron : CellShape::tetrahedron;
  const std::int64_t per_lattice_cell = box.shape == CellShape::hexahedron ? 1 : 6;
  const std::int64_t count = std::int64_t{box.cells[0]} * box.cells[1] * box.cells[2] * per_lattice_cell;
  if (count > most_box_cells)
    reader.refuse(
        "cells", "found " + std::to_string(count) + " cells in all, allowed at most " + std::to_string(most_box_cells));
  if (reader.has("removed_first") != reader.has("removed_last"))
    reader.refuse_missing(reader.has("removed_first") ? "removed_last" : "removed_first",
                          "removed_first and removed_last go together");
  if (!reader.has("removed_first")) return box;
  box.removed = RemovedBlock{reader.integers3("removed_first"), reader.integers3("removed_last")};
  bool all = true;
  for (int axis = 0; axis < 3; ++axis) {
    const int first = box.removed->first[axis], last = box.removed->last[axis];
    if (!(first < last && last <= box.cells[axis]))
      reader.refuse("removed_last",
                    "found " + std::to_string(last) + ", allowed from " + std::to_string(first + 1) +
                        " (past removed_first) to " + std::to_string(box.cells[axis]) + " (cells)",
                    axis);
    all = all && first == 0 && last == box.cells[axis];
  }
  if (all) reader.refuse("removed_last", "found a block that is the whole box, allowed a part of it");
  return box;
}

BaseMesh read_inline_mesh(const SectionReader& reader) {
  BaseMesh mesh;
  mesh.shape = reader.text("shape") == "hexahedron" ? CellShape::hexahedron : CellShape::tetrahedron;
  mesh.nodes = reader.points("nodes");
  const std::size_t corners = static_cast<std::size_t>(corner_count(mesh.shape));
  const auto cells = reader.index_lists("cells");
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const int entry = static_cast<int>(i);
    if (cells[i].size() != corners)
      reader.refuse("cells",
                    "found " + std::to_string(cells[i].size()) + " corners, allowed " + std::to_string(corners), entry);
    for (const int node : cells[i])
      if (node >= mesh.nodes.cols())
        reader.refuse("cells",
                      "found node " + std::to_string(node) + ", allowed 0 to " + std::to_string(mesh.nodes.cols() - 1) +
                          " (mesh.nodes)",
                      entry);
    mesh.cells.push_back(corners_from_file_order(mesh.shape, cells[i]));
    const std::string defect = cell_defect(mesh.shape, mesh.nodes, mesh.cells.back());
    if (!defect.empty()) reader.refuse("cells", defect, entry);
  }
  if (const ConnectionDefect defect = connection_defect(mesh); defect.cell >= 0)
    reader.refuse("cells", defect.words, defect.cell);
  if (const int node = unused_node(mesh); node >= 0)
    reader.refuse("nodes", "found a node without a cell, allowed corners of cells only", node);
  return mesh;
}

}  // namespace

void read_geometry(const SceneDocument& document, Scene& scene) {
  std::vector<std::string> found;
  for (const char* section : {"box", "mesh", "gmsh", "organ"})
    if (document.root().contains(section)) found.emplace_back(section);
  if (found.empty())
    document.fail("box", 0, "found no geometry, required: exactly one of [box], [mesh], [gmsh], [organ]");
  const toml::table* table = document.root().get_as<toml::table>(found.back());
  if (found.size() > 1)
    document.fail(found.back(), table->source().begin.line,
                  "found beside [" + found.front() + "], allowed exactly one of [box], [mesh], [gmsh], [organ]");
  const SectionReader reader(document, found.front(), found.front(), table);
  if (found.front() == "box") {
    scene.geometry = read_box(reader);
  } else if (found.front() == "mesh") {
    scene.geometry = read_inline_mesh(reader);
  } else if (found.front() == "organ") {
    read_organ(reader, document.file().parent_path(), scene);
  } else {
    const std::filesystem::path file = document.file().parent_path() / reader.text("file");
    if (!std::filesystem::is_regular_file(file))
      reader.refuse("file", "found no file \"" + quoted_excerpt(file.string(), 200) + "\"");
    scene.geometry = read_gmsh(file);
  }
}

void read_named_surface(const SectionReader& reader, const BaseMesh& mesh, Scene& scene) {
  SurfaceDefinition surface;
  surface.name = reader.text("name");
  if (mesh.body)
    reader.refuse("name", "found \"" + quoted_excerpt(surface.name) +
                              "\" in a scene with [organ], whose cells' faces are not the body's surface; allowed a "
                              "geometry of full cells, or [[attachment]]");
  if (mesh.surfaces.contains(surface.name))
    reader.refuse("name", "found \"" + quoted_excerpt(surface.name) + "\", allowed a name that no other surface has");
  if (reader.has("normal") == reader.has("nodes"))
    reader.refuse_missing("normal", "exactly one of normal (a plane) and nodes");
  if (reader.has("normal")) {
    if (!reader.has("point")) reader.refuse_missing("point", "needed with normal");
    surface.normal = reader.vector("normal");
    surface.point = reader.vector("point");
    surface.tolerance = reader.number("tolerance");
  } else {
    surface.nodes = reader.index_list("nodes");
    for (std::size_t i = 0; i < surface.nodes.size(); ++i)
      if (surface.nodes[i] >= mesh.nodes.cols())
        reader.refuse("nodes",
                      "found node " + std::to_string(surface.nodes[i]) + ", allowed 0 to " +
                          std::to_string(mesh.nodes.cols() - 1),
                      static_cast<int>(i));
  }
  if (select_faces(mesh, surface).empty())
    reader.refuse(reader.has("normal") ? "normal" : "nodes",
                  "found no face of the boundary there, allowed a surface of at least one");
  scene.surfaces.push_back(std::move(surface));
}

RefinementTemplate read_template(const SectionReader& reader, CellShape shape) {
  const RefinementTemplate refinement = reader.refinement("template");
  if (shape == CellShape::tetrahedron && refinement != RefinementTemplate{})
    reader.refuse("template", "found \"" + to_string(refinement) + "\", allowed \"2x2x2\" for tetrahedra");
  return refinement;
}

}  // namespace finegauge
