#include "benchmarks/program/vtu_writer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>
#include <string_view>

#include "benchmarks/program/atomic_file.hpp"
#include "core/elasticity/cell_response.hpp"

namespace finegauge {
namespace {

template <class T>
constexpr const char* vtk_type();
template <>
constexpr const char* vtk_type<double>() {
  return "Float64";
}
template <>
constexpr const char* vtk_type<std::int64_t>() {
  return "Int64";
}
template <>
constexpr const char* vtk_type<std::uint8_t>() {
  return "UInt8";
}

/// One <DataArray>: an eight-byte count of bytes, then the values.
template <class T>
void write_array(std::string& out, const std::string& name, int components, const T* values, std::size_t count,
                 const std::string& more = {}) {
  const std::uint64_t bytes = count * sizeof(T);
  std::vector<char> payload(sizeof bytes + bytes);
  std::memcpy(payload.data(), &bytes, sizeof bytes);
  if (bytes) std::memcpy(payload.data() + sizeof bytes, values, bytes);
  out += "<DataArray type=\"" + std::string(vtk_type<T>()) + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
         std::to_string(components) + "\"" + more + " format=\"binary\">" + base64(payload.data(), payload.size()) +
         "</DataArray>\n";
}

template <class T>
void write_array(std::string& out, const std::string& name, const std::vector<T>& values) {
  write_array(out, name, 1, values.data(), values.size());
}

/// Corners in VTK's order. A tetrahedron of negative orientation, which Bey's refinement makes, has its last two
/// exchanged: VTK's measures and normals want a positive one.
std::vector<std::int64_t> vtk_connectivity(const Mesh& mesh) {
  std::vector<std::int64_t> connectivity;
  connectivity.reserve(mesh.cells.size() * corner_count(mesh.shape));
  for (const auto& cell : mesh.cells) {
    if (mesh.shape == CellShape::hexahedron) {
      for (const int c : vtk_corner_order) connectivity.push_back(cell[c]);
      continue;
    }
    Eigen::Matrix3d edges;
    for (int c = 0; c < 3; ++c) edges.col(c) = mesh.nodes.col(cell[c + 1]) - mesh.nodes.col(cell[0]);
    const bool positive = edges.determinant() > 0.0;
    for (const int c : {0, 1, positive ? 2 : 3, positive ? 3 : 2}) connectivity.push_back(cell[c]);
  }
  return connectivity;
}

std::string grid_begin(std::size_t nodes, std::size_t cells) {
  static_assert(std::endian::native == std::endian::little, "the byte order below is written as little-endian");
  return "<?xml version=\"1.0\"?>\n"
         "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
         "<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
         std::to_string(nodes) + "\" NumberOfCells=\"" + std::to_string(cells) + "\">\n";
}
constexpr const char* grid_end = "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";

}  // namespace

std::string base64(const void* data, std::size_t size) {
  constexpr char alphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::string text;
  text.reserve((size + 2) / 3 * 4);
  for (std::size_t i = 0; i < size; i += 3) {
    const std::size_t left = size - i;
    const unsigned group = bytes[i] << 16 | (left > 1 ? bytes[i + 1] : 0) << 8 | (left > 2 ? bytes[i + 2] : 0);
    text += alphabet[group >> 18];
    text += alphabet[group >> 12 & 63];
    text += left > 1 ? alphabet[group >> 6 & 63] : '=';
    text += left > 2 ? alphabet[group & 63] : '=';
  }
  return text;
}

std::string vtu_text(const Mesh& mesh, const HangingNodes& hanging, const VtuFields& fields) {
  const std::size_t nodes = mesh.node_count(), cells = mesh.cell_count();
  const auto given = [](Eigen::Index found, [[maybe_unused]] std::size_t expected) {
    assert(found == 0 || found == static_cast<Eigen::Index>(expected));
    return found > 0;
  };
  std::string out = grid_begin(nodes, cells);

  out += "<PointData>\n";
  if (given(fields.displacement.cols(), nodes))
    write_array(out, "displacement", 3, fields.displacement.data(), 3 * nodes);
  if (given(fields.velocity.cols(), nodes)) write_array(out, "velocity", 3, fields.velocity.data(), 3 * nodes);
  std::vector<std::uint8_t> hangs(nodes);
  for (std::size_t i = 0; i < nodes; ++i) hangs[i] = hanging.hangs(static_cast<int>(i));
  write_array(out, "hanging", hangs);
  if (given(fields.recovered_stress.cols(), nodes)) {
    write_array(out, "recovered_stress", 6, fields.recovered_stress.data(), 6 * nodes,
                " ComponentName0=\"XX\" ComponentName1=\"YY\" ComponentName2=\"ZZ\" ComponentName3=\"XY\" "
                "ComponentName4=\"YZ\" ComponentName5=\"XZ\"");
    std::vector<double> mises(nodes);
    for (std::size_t i = 0; i < nodes; ++i) mises[i] = von_mises(fields.recovered_stress.col(i));
    write_array(out, "von_mises", mises);
  }
  out += "</PointData>\n<CellData>\n";
  if (given(fields.eta.size(), cells)) write_array(out, "eta_e", 1, fields.eta.data(), cells);
  std::vector<std::int64_t> depth(cells);
  for (std::size_t e = 0; e < cells; ++e) depth[e] = mesh.frames[e].depth;
  write_array(out, "depth", depth);
  if (given(fields.cell_von_mises.size(), cells)) write_array(out, "von_mises", 1, fields.cell_von_mises.data(), cells);
  if (!mesh.fraction.empty()) write_array(out, "material_share", mesh.fraction);
  out += "</CellData>\n<Points>\n";
  write_array(out, "positions", 3, mesh.nodes.data(), 3 * nodes);

  const int corners = corner_count(mesh.shape);
  std::vector<std::int64_t> offsets(cells);
  for (std::size_t e = 0; e < cells; ++e) offsets[e] = static_cast<std::int64_t>(e + 1) * corners;
  // VTK_TETRA is 10, VTK_HEXAHEDRON is 12.
  const std::vector<std::uint8_t> types(cells, mesh.shape == CellShape::hexahedron ? 12 : 10);
  out += "</Points>\n<Cells>\n";
  write_array(out, "connectivity", vtk_connectivity(mesh));
  write_array(out, "offsets", offsets);
  write_array(out, "types", types);
  return out + grid_end;
}

std::string curve_vtu_text(const Eigen::Matrix3Xd& points) {
  std::string out = grid_begin(static_cast<std::size_t>(points.cols()), 1) + "<Points>\n";
  write_array(out, "positions", 3, points.data(), static_cast<std::size_t>(points.size()));
  std::vector<std::int64_t> connectivity(static_cast<std::size_t>(points.cols()));
  std::iota(connectivity.begin(), connectivity.end(), 0);
  out += "</Points>\n<Cells>\n";
  write_array(out, "connectivity", connectivity);
  write_array(out, "offsets", std::vector<std::int64_t>{points.cols()});
  write_array(out, "types", std::vector<std::uint8_t>{4});  // VTK_POLY_LINE
  return out + grid_end;
}

std::string surface_vtu_text(const TriangleSurface& surface, const Eigen::Matrix3Xd& displacement) {
  const std::size_t vertices = static_cast<std::size_t>(surface.vertices.cols());
  std::string out = grid_begin(vertices, surface.triangles.size());
  if (displacement.cols() > 0) {
    out += "<PointData>\n";
    write_array(out, "displacement", 3, displacement.data(), 3 * vertices);
    out += "</PointData>\n";
  }
  out += "<Points>\n";
  write_array(out, "positions", 3, surface.vertices.data(), 3 * vertices);
  std::vector<std::int64_t> connectivity, offsets;
  for (const std::array<int, 3>& triangle : surface.triangles) {
    connectivity.insert(connectivity.end(), triangle.begin(), triangle.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  out += "</Points>\n<Cells>\n";
  write_array(out, "connectivity", connectivity);
  write_array(out, "offsets", offsets);
  write_array(out, "types", std::vector<std::uint8_t>(surface.triangles.size(), 5));  // VTK_TRIANGLE
  return out + grid_end;
}

void write_surface_vtu(const std::filesystem::path& file, const TriangleSurface& surface,
                       const Eigen::Matrix3Xd& displacement) {
  write_file_atomically(file, surface_vtu_text(surface, displacement));
}

void write_curve_vtu(const std::filesystem::path& file, const Eigen::Matrix3Xd& points) {
  write_file_atomically(file, curve_vtu_text(points));
}

VtuFields vtu_fields(const Discretization& d, const Eigen::Matrix3Xd& u, const ErrorEstimate& estimate) {
  VtuFields fields;
  fields.displacement = u;
  fields.recovered_stress = estimate.nodal_stress;
  fields.eta = estimate.eta;
  const CellStresses stresses = cell_stresses(d, u);
  fields.cell_von_mises.resize(stresses.centre.cols());
  for (Eigen::Index cell = 0; cell < stresses.centre.cols(); ++cell)
    fields.cell_von_mises[cell] = von_mises(stresses.centre.col(cell));
  return fields;
}

void write_vtu(const std::filesystem::path& file, const Mesh& mesh, const HangingNodes& hanging,
               const VtuFields& fields) {
  write_file_atomically(file, vtu_text(mesh, hanging, fields));
}

std::string vtu_series_file(const std::string& name, int step) {
  char number[16];
  std::snprintf(number, sizeof number, "_%04d", step);
  return name + number + ".vtu";
}

void remove_vtu_series(const std::filesystem::path& directory, const std::string& name) {
  const auto in_series = [&](const std::string& file) {
    constexpr std::string_view ending = ".vtu";
    const std::string start = name + "_";
    if (!file.starts_with(start) || !file.ends_with(ending) || file.size() < start.size() + 4 + ending.size())
      return false;
    return std::all_of(file.begin() + static_cast<std::ptrdiff_t>(start.size()),
                       file.end() - static_cast<std::ptrdiff_t>(ending.size()),
                       [](char c) { return '0' <= c && c <= '9'; });
  };
  if (!std::filesystem::is_directory(directory)) return;
  std::vector<std::filesystem::path> old;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    if (entry.is_regular_file() && in_series(entry.path().filename().string())) old.push_back(entry.path());
  for (const std::filesystem::path& file : old) std::filesystem::remove(file);
}

void write_pvd(const std::filesystem::path& file, const std::vector<std::pair<double, std::string>>& times_and_files) {
  std::string out =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
      "<Collection>\n";
  for (const auto& [time, name] : times_and_files) {
    // The JSON library prints the shortest digits that read back as the same number, whatever the locale.
    out += "<DataSet timestep=\"" + nlohmann::json(time).dump() + "\" part=\"0\" file=\"";
    for (const char c : name) out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
    out += "\"/>\n";
  }
  write_file_atomically(file, out + "</Collection>\n</VTKFile>\n");
}

}  // namespace finegauge
