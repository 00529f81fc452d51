// A mesh file: read_gmsh gives a sound mesh or refuses, within memory that goes with the size of the file.

#include "core/mesh/base_mesh.hpp"
#include "core/scene/gmsh_reader.hpp"
#include "verification/fuzz/fuzz_input.hpp"

using namespace finegauge;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const FuzzFolder folder;
  const std::filesystem::path file = folder.write("mesh.msh", text_of(data, size));
  BaseMesh mesh;
  HeapPeak::begin();
  const bool accepted = accepts(folder, [&] { mesh = read_gmsh(file); });
  check_memory(HeapPeak::bytes(), size);
  if (!accepted) return 0;
  if (const std::string defect = validate(mesh); !defect.empty()) report_finding("accepted an unsound mesh: " + defect);
  for (const auto& [name, faces] : mesh.surfaces)
    if (name.empty() || faces.empty()) report_finding("accepted a surface without a name or without faces");
  return 0;
}
