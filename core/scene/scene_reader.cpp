#include "core/scene/scene_reader.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/mesh/point_location.hpp"
#include "core/scene/attachment_reader.hpp"
#include "core/scene/attachments.hpp"
#include "core/scene/dynamics_reader.hpp"
#include "core/scene/geometry_reader.hpp"
#include "core/scene/needle_reader.hpp"
#include "core/scene/scene_document.hpp"
#include "core/scene/scene_keys.hpp"
#include "core/scene/section_reader.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

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

std::string surface_name(const SectionReader& reader, const BaseMesh& mesh) {
  const std::string name = reader.text("surface");
  if (mesh.body)
    reader.refuse("surface", "found \"" + quoted_excerpt(name) +
                                 "\" in a scene with [organ], which has none: the faces of its cells are not the "
                                 "body's surface; allowed [[attachment]], which holds or moves a part of it");
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
  support.course = read_course(reader);
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
  const std::string kind = reader.text("kind");
  if (kind == "tip_force" || kind == "force_curve") {
    quantity.kind = kind == "tip_force" ? QuantityKind::tip_force : QuantityKind::force_curve;
    if (!scene.needle)
      reader.refuse("kind", "found \"" + kind + "\" in a scene without [needle], allowed only with it");
  }
  if (kind == "displacement") {
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
    if (!locate_at_rest(mesh, quantity.point))
      reader.refuse("point", "found [" + std::to_string(quantity.point.x()) + ", " +
                                 std::to_string(quantity.point.y()) + ", " + std::to_string(quantity.point.z()) +
                                 "], where there is no cell, allowed are points of the body");
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
  const auto given = [&](const char* section) { return document.root().contains(section); };
  if (given("needle") || given("contact") || given("stroke")) check_needle_sections(document);
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
  const bool moving = given("dynamics");
  if (!moving) scene.solver = read_solver(single("solver"));

  read_geometry(document, scene);
  BaseMesh mesh;
  // Imported meshes are checked where they are read; a box is sound unless rounding makes its nodes coincide.
  const bool box = std::holds_alternative<BoxMeshOptions>(scene.geometry);
  std::string defect;
  try {
    mesh = base_mesh(scene);
    if (box) defect = validate(mesh);
  } catch (const std::invalid_argument& refused) {
    if (!box) throw;
    defect = refused.what();
  }
  if (!defect.empty()) single("box").refuse("size", "found an unsound mesh: " + defect);
  for (const SectionReader& reader : repeated(document, "surface")) {
    read_named_surface(reader, mesh, scene);
    mesh.surfaces[scene.surfaces.back().name] = select_faces(mesh, scene.surfaces.back());
  }

  for (const SectionReader& reader : repeated(document, "support"))
    scene.supports.push_back(read_support(reader, mesh));
  for (const SectionReader& reader : repeated(document, "attachment")) read_attachment(reader, mesh, scene);
  add_regions(scene.attachments, mesh);
  for (const char* section : {"attachment", "support"})
    if (const auto* holders = document.root().get(section))
      scene.support_line = static_cast<int>(holders->source().begin.line);
  for (const SectionReader& reader : repeated(document, "load")) read_load(reader, mesh, scene);
  for (const SectionReader& reader : repeated(document, "refine"))
    scene.refinements.push_back(read_refinement(reader, mesh.shape));
  if (given("needle")) read_needle(document, mesh, scene);
  if (given("adapt") && single("adapt").text("estimator") == "spr") scene.estimator = Estimator::spr;
  if (moving)
    read_dynamics(document, mesh.shape, scene);
  else if (given("adapt") && single("adapt").boolean("enabled"))
    scene.adapt = read_adapt(single("adapt"), mesh.shape);
  for (const SectionReader& reader : repeated(document, "quantity")) read_quantity(reader, mesh, scene);
  return scene;
}

}  // namespace finegauge
