#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/adapt/error_estimate.hpp"
#include "core/mesh/hanging_nodes.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/triangle_surface.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// Fields on a mesh; those left empty are not written.
struct VtuFields {
  Eigen::Matrix3Xd displacement;                              ///< [m], 3 × n_nodes
  Eigen::Matrix3Xd velocity;                                  ///< [m/s], 3 × n_nodes
  Eigen::Matrix<double, 6, Eigen::Dynamic> recovered_stress;  ///< [Pa], xx yy zz xy yz zx, 6 × n_nodes
  Eigen::VectorXd eta;                                        ///< η_e [√J], per cell
  Eigen::VectorXd cell_von_mises;                             ///< [Pa], per cell
};

/// The fields of a solution.
VtuFields vtu_fields(const Discretization& d, const Eigen::Matrix3Xd& u, const ErrorEstimate& estimate);

/// A mesh as VTK's unstructured grid (.vtu, XML, base64): rest positions as points; point data `displacement`,
/// `velocity`, `hanging` (0 or 1), `recovered_stress` (in VTK's order XX YY ZZ XY YZ XZ, which is ours), `von_mises` of
/// the recovered stress; cell data `eta_e`, `depth`, `von_mises`, and `material_share` where not all cells are full. A
/// hanging node is a point like any other: the grid shows the leaves as they are, with the coarse neighbour's face
/// straight.
std::string vtu_text(const Mesh& mesh, const HangingNodes& hanging, const VtuFields& fields);

/// Atomically, as every result file.
void write_vtu(const std::filesystem::path& file, const Mesh& mesh, const HangingNodes& hanging,
               const VtuFields& fields);

/// A curve through points (3 × n, n >= 2) as one poly-line of VTK: a needle where it is. ParaView's filter Tube gives
/// it its thickness.
std::string curve_vtu_text(const Eigen::Matrix3Xd& points);
void write_curve_vtu(const std::filesystem::path& file, const Eigen::Matrix3Xd& points);

/// A surface of triangles where it is, positions [m] with, unless it has no columns, the `displacement` that led there.
std::string surface_vtu_text(const TriangleSurface& surface, const Eigen::Matrix3Xd& displacement);
void write_surface_vtu(const std::filesystem::path& file, const TriangleSurface& surface,
                       const Eigen::Matrix3Xd& displacement);

/// NAME_0012.vtu of step 12, at least four digits.
std::string vtu_series_file(const std::string& name, int step);
/// Removes the NAME_0000.vtu, NAME_0001.vtu, ... of an earlier run, which a viewer would take for this run's; no other
/// file. A directory that does not exist has none.
void remove_vtu_series(const std::filesystem::path& directory, const std::string& name);

/// The collection that ParaView opens as a time series: times and file names relative to the collection.
void write_pvd(const std::filesystem::path& file, const std::vector<std::pair<double, std::string>>& times_and_files);

/// RFC 4648, with padding.
std::string base64(const void* data, std::size_t size);

}  // namespace finegauge
