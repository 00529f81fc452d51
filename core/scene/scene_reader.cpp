#include "core/scene/scene_reader.hpp"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "core/scene/gmsh_reader.hpp"
#include "core/scene/imported_mesh.hpp"
#include "core/scene/scene_document.hpp"
#include "core/scene/scene_keys.hpp"
#include "core/scene/section_reader.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

constexpr std::int64_t most_box_cells = 4'000'000;

bool is_text_key(const std::string& section, const std::string& key) {
  const SceneKey* row = find_key(section, key);
  return row && (row->type == KeyType::text || row->type == KeyType::choice || row->type == KeyType::refinement);
}

/// The readers of all sections of a name, in the order of the file.
std::vector<SectionReader> repeated(const SceneDocument& document, const std::string& section) {
  std::vector<SectionReader> readers;
  const toml::array* list = document.root().get_as<toml::array>(section);
  for (std::size_t i = 0; list && i < list->size(); ++i)
    readers.emplace_back(document, section, section + "[" + std::to_string(i) + "]", list->get_as<toml::table>(i));
  return readers;
}

/// Every entry of the root is a known key, or a known section in the right brackets; required sections are there.
void check_sections(const SceneDocument& document) {
  for (const auto& [key, node] : document.root()) {
    const std::string name(key.str());
    const auto line = key.source().begin.line;
    if (find_key("", name)) continue;
    const SceneSection* section = name.empty() ? nullptr : find_section(name);
    if (!section) {
      const bool is_section = node.is_table() || node.is_array_of_tables();
      document.fail(quoted_excerpt(name), line,
                    is_section ? "unknown section" + suggest_section(name) : "unknown key" + suggest_key("", name));
    }
    const std::string allowed = section->repeated ? "[[" + name + "]]" : "[" + name + "]";
    if (!(section->repeated ? node.is_array_of_tables() : node.is_table()))
      document.fail(name, line, "found " + excerpt(node) + ", allowed the section " + allowed);
  }
  for (const SceneSection& section : scene_sections())
    if (section.required && !section.name.empty() && !document.root().contains(section.name))
      document.fail(std::string(section.name), 0,
                    "found nothing, required: the section [" + std::string(section.name) + "]");
}

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

void read_geometry(const SceneDocument& document, Scene& scene) {
  std::vector<std::string> found;
  for (const char* section : {"box", "mesh", "gmsh"})
    if (document.root().contains(section)) found.emplace_back(section);
  if (found.empty()) document.fail("box", 0, "found no geometry, required: exactly one of [box], [mesh], [gmsh]");
  const toml::table* table = document.root().get_as<toml::table>(found.back());
  if (found.size() > 1)
    document.fail(found.back(), table->source().begin.line,
                  "found beside [" + found.front() + "], allowed exactly one of [box], [mesh], [gmsh]");
  const SectionReader reader(document, found.front(), found.front(), table);
  if (found.front() == "box") {
    scene.geometry = read_box(reader);
  } else if (found.front() == "mesh") {
    scene.geometry = read_inline_mesh(reader);
  } else {
    const std::filesystem::path file = document.file().parent_path() / reader.text("file");
    if (!std::filesystem::is_regular_file(file))
      reader.refuse("file", "found no file \"" + quoted_excerpt(file.string(), 200) + "\"");
    scene.geometry = read_gmsh(file);
  }
}

void read_surface(const SectionReader& reader, const BaseMesh& mesh, Scene& scene) {
  SurfaceDefinition surface;
  surface.name = reader.text("name");
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

std::string surface_name(const SectionReader& reader, const BaseMesh& mesh) {
  const std::string name = reader.text("surface");
  if (mesh.surfaces.contains(name)) return name;
  std::string known;
  for (const auto& [surface, faces] : mesh.surfaces) known += (known.empty() ? "" : ", ") + surface;
  reader.refuse("surface", "found \"" + quoted_excerpt(name) + "\", allowed one of " + quoted_excerpt(known, 400));
}

SceneSupport read_support(const SectionReader& reader, const BaseMesh& mesh) {
  SceneSupport support;
  support.surface = surface_name(reader, mesh);
  if (reader.has("normal") && reader.has("components"))
    reader.refuse("components", "found beside normal, allowed one of the two");
  if (reader.has("normal")) support.normal = reader.vector("normal");
  if (reader.has("components")) support.components = reader.axes("components");
  support.displacement = reader.vector("displacement");
  support.gradient = reader.matrix("gradient");
  return support;
}

void read_load(const SectionReader& reader, const BaseMesh& mesh, Scene& scene) {
  const int kinds = reader.has("traction") + reader.has("total_force") + reader.has("body_force");
  if (kinds != 1)
    reader.refuse("traction",
                  "found " + std::to_string(kinds) + " of traction, total_force and body_force, allowed exactly one");
  if (reader.has("share") && !reader.has("total_force"))
    reader.refuse("share", "found without total_force, allowed only with it");
  if (reader.has("body_force")) {
    if (reader.has("surface")) reader.refuse("surface", "found beside body_force, which acts on the whole body");
    scene.body_force += reader.vector("body_force");
    return;
  }
  if (!reader.has("surface")) reader.refuse_missing("surface", "needed with traction and total_force");
  SurfaceLoad load;
  load.surface = surface_name(reader, mesh);
  load.value = reader.vector(reader.has("traction") ? "traction" : "total_force");
  if (reader.has("total_force"))
    load.kind = reader.text("share") == "area" ? LoadKind::total_by_area : LoadKind::total_by_node;
  scene.loads.push_back(std::move(load));
}

RefinementTemplate read_template(const SectionReader& reader, CellShape shape) {
  const RefinementTemplate refinement = reader.refinement("template");
  if (shape == CellShape::tetrahedron && refinement != RefinementTemplate{})
    reader.refuse("template", "found \"" + to_string(refinement) + "\", allowed \"2x2x2\" for tetrahedra");
  return refinement;
}

InitialRefinement read_refinement(const SectionReader& reader, CellShape shape) {
  InitialRefinement refinement;
  const bool region = reader.has("min") || reader.has("max");
  if (reader.boolean("all") == region)
    reader.refuse_missing("all", "exactly one of all = true and a region with min and max");
  if (region) {
    for (const char* corner : {"min", "max"})
      if (!reader.has(corner)) reader.refuse_missing(corner, "min and max go together");
    refinement.min = reader.vector("min");
    refinement.max = reader.vector("max");
    if (!(refinement.min.array() < refinement.max.array()).all())
      reader.refuse("max", "found a corner that is not above min in x, y and z, allowed > min");
  }
  refinement.refinement = read_template(reader, shape);
  refinement.levels = reader.integer("levels");
  return refinement;
}

AdaptRules read_adapt(const SectionReader& reader, CellShape shape) {
  AdaptRules adapt;
  adapt.steps = reader.integer("steps");
  const std::string marking = reader.text("marking");
  adapt.marking = marking == "maximum"    ? Marking::maximum
                  : marking == "bulk"     ? Marking::bulk
                  : marking == "fraction" ? Marking::fraction
                                          : Marking::threshold;
  adapt.theta = reader.number("theta");
  if (adapt.marking == Marking::threshold && !reader.has("threshold"))
    reader.refuse_missing("threshold", "needed with marking = \"threshold\"");
  if (reader.has("threshold")) adapt.threshold = reader.number("threshold");
  adapt.policy = reader.text("policy") == "template" ? RefinementPolicy::one_template : RefinementPolicy::directional;
  adapt.refinement = read_template(reader, shape);
  adapt.tolerance = reader.number("tolerance");
  adapt.max_depth = reader.integer("max_depth");
  adapt.max_dofs = reader.integer("max_dofs");
  return adapt;
}

EquilibriumOptions read_solver(const SectionReader& reader) {
  EquilibriumOptions solver;
  const std::string method = reader.text("method");
  solver.method = method == "direct"      ? LinearMethod::direct
                  : method == "multigrid" ? LinearMethod::multigrid
                                          : LinearMethod::automatic;
  solver.linear.relative_residual = reader.number("relative_residual");
  solver.linear.iterations = reader.integer("iterations");
  solver.newton_iterations = reader.integer("newton_iterations");
  solver.newton_residual = reader.number("newton_residual");
  return solver;
}

Material read_material(const SectionReader& reader) {
  Material material;
  material.youngs_modulus = reader.number("youngs_modulus");
  material.poisson_ratio = reader.number("poisson_ratio");
  material.dilatation = reader.text("dilatation") == "mean" ? Dilatation::mean : Dilatation::standard;
  material.kinematics = reader.text("kinematics") == "linear" ? Kinematics::linear : Kinematics::corotational;
  return material;
}

void read_quantity(const SectionReader& reader, const BaseMesh& mesh, Scene& scene) {
  QuantityOfInterest quantity;
  quantity.name = reader.has("name") ? reader.text("name") : reader.text("kind");
  for (const QuantityOfInterest& other : scene.quantities)
    if (other.name == quantity.name)
      reader.refuse("name", "found \"" + quoted_excerpt(quantity.name) + "\" twice, allowed once");
  if (reader.text("kind") == "displacement") {
    quantity.kind = QuantityKind::displacement;
    if (!reader.has("point")) reader.refuse_missing("point", "needed with kind = \"displacement\"");
    quantity.point = reader.vector("point");
    const Eigen::Vector3d low = mesh.nodes.rowwise().minCoeff(), high = mesh.nodes.rowwise().maxCoeff();
    const double slack = 1e-9 * (high - low).norm();
    for (int axis = 0; axis < 3; ++axis)
      if (!(quantity.point[axis] >= low[axis] - slack && quantity.point[axis] <= high[axis] + slack))
        reader.refuse("point",
                      "found " + std::to_string(quantity.point[axis]) + ", allowed in [" + std::to_string(low[axis]) +
                          ", " + std::to_string(high[axis]) + "] (the bounding box of the body)",
                      axis);
  }
  scene.quantities.push_back(std::move(quantity));
}

std::string scene_name(const SectionReader& reader, const std::filesystem::path& file) {
  if (!reader.has("name")) return file.stem().string();
  const std::string name = reader.text("name");
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
  });
  if (!plain || name.front() == '.')  // result files are named so
    reader.refuse("name", "found \"" + quoted_excerpt(name) +
                              "\", allowed letters, digits, '_', '-' and '.', and no '.' at the start");
  return name;
}

}  // namespace

Scene read_scene(const std::filesystem::path& file, std::span<const std::string> overrides) {
  const SceneDocument document(file, overrides, is_text_key);
  check_sections(document);
  const auto single = [&](const std::string& section) {
    return SectionReader(document, section, section, document.root().get_as<toml::table>(section));
  };

  Scene scene;
  scene.file = file.string();
  const SectionReader top(document, "", "", &document.root());
  scene.name = scene_name(top, file);
  scene.description = top.text("description");
  scene.dimensionless = top.text("units") == "none";
  scene.material = read_material(single("material"));
  scene.solver = read_solver(single("solver"));

  read_geometry(document, scene);
  BaseMesh mesh = base_mesh(scene);
  // Imported meshes are checked where they are read; a box is sound unless rounding makes its nodes coincide.
  if (std::holds_alternative<BoxMeshOptions>(scene.geometry))
    if (const std::string defect = validate(mesh); !defect.empty())
      single("box").refuse("size", "found an unsound mesh: " + defect);
  for (const SectionReader& reader : repeated(document, "surface")) {
    read_surface(reader, mesh, scene);
    mesh.surfaces[scene.surfaces.back().name] = select_faces(mesh, scene.surfaces.back());
  }

  for (const SectionReader& reader : repeated(document, "support"))
    scene.supports.push_back(read_support(reader, mesh));
  if (const auto* supports = document.root().get("support"))
    scene.support_line = static_cast<int>(supports->source().begin.line);
  for (const SectionReader& reader : repeated(document, "load")) read_load(reader, mesh, scene);
  for (const SectionReader& reader : repeated(document, "refine"))
    scene.refinements.push_back(read_refinement(reader, mesh.shape));
  if (document.root().contains("adapt")) scene.adapt = read_adapt(single("adapt"), mesh.shape);
  for (const SectionReader& reader : repeated(document, "quantity")) read_quantity(reader, mesh, scene);
  return scene;
}

}  // namespace finegauge
