// A surface file: read_surface gives triangles whose vertices exist and are finite, or refuses; check_surface gives a
// closed surface in which it finds nothing more to repair, or refuses.

#include <array>

#include "core/mesh/triangle_surface.hpp"
#include "core/scene/stl_reader.hpp"
#include "core/scene/surface_check.hpp"
#include "core/scene/surface_reader.hpp"
#include "verification/fuzz/fuzz_input.hpp"

using namespace finegauge;

namespace {

/// Of one file: the last, and links to it.
constexpr std::array<const char*, 5> names = {"surface.obj", "surface.stl", "surface.ply", "surface.msh",
                                              "surface.dat"};

bool link_names(const FuzzFolder& folder) {
  for (const char* name : names)
    if (name != names.back()) std::filesystem::create_symlink(names.back(), folder.path() / name);
  return true;
}

/// Whether the extension makes no difference (surface_reader.hpp).
bool is_told_by_content(std::string_view bytes) {
  return bytes.starts_with("ply\n") || bytes.starts_with("ply\r\n") || bytes.starts_with("$MeshFormat") ||
         is_binary_stl(bytes);
}

void check_indices(const TriangleSurface& surface) {
  if (surface.triangles.empty()) report_finding("accepted a surface without triangles");
  if (!surface.vertices.allFinite()) report_finding("accepted a vertex that is not finite");
  for (const auto& corners : surface.triangles)
    for (const int vertex : corners)
      if (vertex < 0 || vertex >= surface.vertices.cols()) report_finding("accepted a corner that is no vertex");
}

bool are_same(const TriangleSurface& a, const TriangleSurface& b) {
  return a.triangles == b.triangles && a.vertices.cols() == b.vertices.cols() && a.vertices == b.vertices;
}

void check_checked(const FuzzFolder& folder, const TriangleSurface& surface, const std::string& name) {
  CheckedSurface checked;
  if (!accepts(folder, [&] { checked = check_surface(surface, name); })) return;
  check_indices(checked.surface);
  if (open_edge(checked.surface)) report_finding("accepted a surface that is not closed");
  CheckedSurface again;
  if (!accepts(folder, [&] { again = check_surface(checked.surface, name); }))
    report_finding("refused a surface that it had repaired");
  if (!are_same(checked.surface, again.surface)) report_finding("repaired a surface twice");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const FuzzFolder folder;
  [[maybe_unused]] static const bool has_names = link_names(folder);
  const std::string_view bytes = text_of(data, size);
  folder.write(names.back(), bytes);
  const bool once = is_told_by_content(bytes);
  for (const char* name : names) {
    const std::filesystem::path file = folder.path() / name;
    TriangleSurface surface;
    HeapPeak::begin();
    const bool accepted = accepts(folder, [&] { surface = read_surface(file); });
    check_memory(HeapPeak::bytes(), size);
    if (accepted) {
      check_indices(surface);
      check_checked(folder, surface, file.string());
    }
    if (once) break;
  }
  return 0;
}
