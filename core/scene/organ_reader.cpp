#include "core/scene/organ_reader.hpp"

#include <filesystem>
#include <stdexcept>
#include <utility>

#include "core/mesh/immersed_body.hpp"
#include "core/scene/surface_check.hpp"
#include "core/scene/surface_reader.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

constexpr double most_cells_away = 1e6;  // 1e-10 of a cell by rounding

}  // namespace

void read_organ(const SectionReader& reader, const std::filesystem::path& folder, Scene& scene) {
  const std::filesystem::path file = folder / reader.text("surface");
  if (!std::filesystem::is_regular_file(file))
    reader.refuse("surface", "found no file \"" + quoted_excerpt(file.string(), 200) + "\"");
  // Checked as the file has it, so that messages name its own coordinates.
  CheckedSurface checked = check_surface(read_surface(file), file.string());
  for (const std::string& note : checked.notes) scene.notes.push_back(file.filename().string() + ": " + note);
  const double scale = reader.number("scale");
  checked.surface.vertices *= scale;
  if (!checked.surface.vertices.allFinite())
    reader.refuse("scale", "found a scale that takes the surface's coordinates out of range, allowed finite ones");

  ImmersedMeshOptions options;
  options.cell_size.setConstant(reader.number("cell_size"));
  if (reader.has("origin")) {
    options.origin = reader.vector("origin");
    const Eigen::Vector3d distance = checked.surface.vertices.col(0) - *options.origin;
    if (!(distance.cwiseAbs().maxCoeff() <= most_cells_away * options.cell_size.maxCoeff()))
      reader.refuse("origin",
                    "found a corner far from the surface, allowed one within a million cells of it (farther, "
                    "rounding moves the lattice)");
  }
  BaseMesh mesh;
  std::string defect;
  try {
    mesh = immersed_mesh(std::move(checked.surface), options);
    defect = validate(mesh);  // rounding spoils small cells far from zero
  } catch (const std::invalid_argument& refused) {
    defect = refused.what();
  }
  if (!defect.empty()) reader.refuse("cell_size", "found no lattice for the surface: " + defect);
  scene.geometry = std::move(mesh);
}

}  // namespace finegauge
