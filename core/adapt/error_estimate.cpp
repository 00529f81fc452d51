#include "core/adapt/error_estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/parallel/for_parts.hpp"
#include "core/space/free_surface.hpp"

namespace finegauge {

namespace {

/// A stress in the first six of eight lanes, so that one vector register or two hold it. The last two hold anything
/// finite; energies give them no weight.
using Lanes = Eigen::Array<double, 8, 1>;

const Lanes third_of_trace = (Lanes() << 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0).finished() / 3.0;

/// A copy of the stresses, a cache line each: cells visit a node's eight times.
Eigen::Matrix<double, 8, Eigen::Dynamic> padded(const Eigen::Matrix<double, 6, Eigen::Dynamic>& stress) {
  Eigen::Matrix<double, 8, Eigen::Dynamic> lanes(8, stress.cols());
  lanes.topRows<6>() = stress;
  lanes.bottomRows<2>().setZero();
  return lanes;
}

/// Σ weight · σ:C⁻¹:σ as dev σ:dev σ / (2 mu) + (tr σ)² / (9 bulk): unlike the form in E and nu it cannot turn negative
/// by cancellation as nu -> 1/2.
class ComplementaryEnergy {
 public:
  void add(double weight, const Lanes& sigma) {
    const double trace = sigma[0] + sigma[1] + sigma[2];
    deviatoric_ += weight * (sigma - trace * third_of_trace).square();
    volumetric_ += weight * trace * trace;
  }
  double value(const Material& material) const {
    // The off-diagonal components count twice.
    const double deviatoric = deviatoric_.head<3>().sum() + 2.0 * deviatoric_.segment<3>(3).sum();
    return 0.5 / material.mu() * deviatoric + volumetric_ / (9.0 * material.bulk());
  }

 private:
  Lanes deviatoric_ = Lanes::Zero();
  double volumetric_ = 0.0;
};

/// From values at the corners to values at the 2×2×2 Gauss points, axis by axis.
void interpolate_to_quadrature(std::array<Lanes, 8>& values) {
  const double near = 0.5 * (1.0 + 1.0 / std::sqrt(3.0)), far = 1.0 - near;
  for (const int step : {1, 2, 4})
    for (int c = 0; c < 8; ++c) {
      if (c & step) continue;
      const Lanes low = values[c], high = values[c + step];
      values[c] = near * low + far * high;
      values[c + step] = far * low + near * high;
    }
}

struct CellError {
  double error_squared;  ///< ∫ (σ_h - σ_s):C⁻¹:(σ_h - σ_s) [J]
  double energy;         ///< ∫ σ_h:C⁻¹:σ_h [J]
  Eigen::Vector3d direction;
};

const Eigen::Vector3d equal_shares = Eigen::Vector3d::Constant(1.0 / 3.0);

/// The coefficient odd in one natural coordinate and even in the two others, per axis; where their energies are
/// round-off of the cell's error (1e-12 of it, a millionth of its amplitude) they point nowhere.
Eigen::Vector3d directional_shares(const Material& material, const std::array<Lanes, 8>& error, double volume,
                                   double error_squared) {
  Eigen::Vector3d share;
  for (int i = 0; i < 3; ++i) {
    Lanes odd = Lanes::Zero();
    for (int q = 0; q < 8; ++q) {
      if ((q >> i) & 1)
        odd += error[q];
      else
        odd -= error[q];
    }
    ComplementaryEnergy energy;
    energy.add(volume / 64.0, odd);
    share[i] = energy.value(material);
  }
  const double sum = share.sum();
  if (!(sum > 1e-12 * error_squared && sum > 0.0)) return equal_shares;
  return share / sum;
}

/// Quadrature weights over the part of a cell that is material, as if it filled the cell [m³]: not negative, and with
/// its mean place where that lies between the quadrature points. The error at the far end of a cell, where its material
/// is not, counts little then.
std::array<double, 8> weights_at_material(const CellGeometry& geometry, const MaterialMeans& means) {
  const double low = quadrature_point(CellShape::hexahedron, 0)[0],
               high = quadrature_point(CellShape::hexahedron, 7)[0];
  Eigen::Vector3d upper;
  for (int axis = 0; axis < 3; ++axis) upper[axis] = std::clamp((means[axis] - low) / (high - low), 0.0, 1.0);
  std::array<double, 8> weights;
  for (int q = 0; q < 8; ++q) {
    weights[q] = geometry.volume;
    for (int axis = 0; axis < 3; ++axis) weights[q] *= (q >> axis) & 1 ? upper[axis] : 1.0 - upper[axis];
  }
  return weights;
}

CellError hexahedron_error(const Material& material, const CellGeometry& geometry, const std::array<double, 8>& weights,
                           const double* stress, const std::array<Lanes, 8>& recovered_at_corners) {
  std::array<Lanes, 8> error = recovered_at_corners;
  interpolate_to_quadrature(error);
  ComplementaryEnergy error_squared, energy;
  for (int q = 0; q < 8; ++q) {
    Lanes sigma;
    if (q < 7)
      sigma = Eigen::Map<const Lanes>(stress + 6 * q);  // and two of the next point, in the lanes without weight
    else
      sigma << Eigen::Map<const Eigen::Array<double, 6, 1>>(stress + 6 * q), 0.0, 0.0;
    error[q] = sigma - error[q];
    error_squared.add(weights[q], error[q]);
    energy.add(weights[q], sigma);
  }
  CellError result{error_squared.value(material), energy.value(material), equal_shares};
  result.direction = directional_shares(material, error, geometry.volume, result.error_squared);
  return result;
}

/// σ_h is constant and σ_s linear: ∫ N_a N_b = V (1 + δ_ab) / 20.
CellError tetrahedron_error(const Material& material, const CellGeometry& geometry, const double* stress,
                            const std::array<Lanes, 8>& recovered_at_corners) {
  Lanes sigma;
  sigma << Eigen::Map<const Eigen::Array<double, 6, 1>>(stress), 0.0, 0.0;
  ComplementaryEnergy error_squared, energy;
  Lanes sum = Lanes::Zero();
  for (int c = 0; c < 4; ++c) {
    const Lanes error = sigma - recovered_at_corners[c];
    error_squared.add(geometry.volume / 20.0, error);
    sum += error;
  }
  error_squared.add(geometry.volume / 20.0, sum);
  energy.add(geometry.volume, sigma);
  return {error_squared.value(material), energy.value(material), equal_shares};
}

/// Unresolved of a singular field at an edge: what the weights of the header say.
struct EdgeWeights {
  double largest_gain;     ///< w - 1
  double share_of_energy;  ///< c
};

EdgeWeights edge_weights_of_tetrahedron(const SingularEdge& edge) {
  const auto of = [&](const TetrahedronWeights& by_place) {
    return edge.lies_along ? by_place.along : by_place.at_corner;
  };
  if (edge.cells == 1)
    return {of(share_of_rim_gain) * std::exp(4.1 - 5.28 * edge.exponent()),
            tetrahedra_share_of_rim * rim_energy_share(edge.exponent())};
  const bool on_face = edge.lies_along && !edge.within;
  return {on_face ? 0.0 : of(tetrahedra_at_notch) - 1.0, of(tetrahedra_notch_energy_share(edge.exponent()))};
}

EdgeWeights edge_weights(const SingularEdge& edge, const Material& material, CellShape shape) {
  if (!edge) return {0.0, 0.0};
  if (shape == CellShape::tetrahedron) return edge_weights_of_tetrahedron(edge);
  const bool rim = edge.cells == 1;
  const double gain = singular_edge_weights[static_cast<std::size_t>(edge.cells) - 1] - 1.0;
  if (!rim) return {gain, notch_energy_share};
  const double locking = material.dilatation == Dilatation::mean ? rim_share_of_mean_dilatation : 1.0;
  return {gain, locking * rim_energy_share(edge.exponent())};
}

/// Of a cell, with the share of it that is material [J].
struct Squares {
  double error, energy;
};

/// To cells of tetrahedra that touch no singular edge, for what the edges take from the whole field.
void add_pollution(const std::vector<SingularEdge>& edges, std::vector<Squares>& squares) {
  double near = 0.0, far = 0.0, polluting = 0.0;
  for (std::size_t cell = 0; cell < squares.size(); ++cell) {
    (edges[cell] ? near : far) += squares[cell].error;
    if (edges[cell]) polluting += pollution_share(edges[cell].exponent()) * squares[cell].error;
  }
  if (!(near > 0.0 && far > 0.0)) return;
  const double share = polluting / near * std::min(1.0, most_pollution_of_near * near / far);
  for (std::size_t cell = 0; cell < squares.size(); ++cell)
    if (!edges[cell]) squares[cell].error *= 1.0 + share;
}

/// 1 / (1 - est²/‖u_h‖²) where loads alone drive the body, else 1.
double factor_for_amplitude(const Discretization& d, const std::vector<Squares>& squares) {
  if (!d.driven_by_loads || d.shapes.material().kinematics != Kinematics::linear) return 1.0;
  double error = 0.0, energy = 0.0;
  for (const Squares& of_cell : squares) {
    error += of_cell.error;
    energy += of_cell.energy;
  }
  return energy > 0.0 ? 1.0 / (1.0 - std::min(largest_lost_amplitude, error / energy)) : 1.0;
}

/// Of a recovered stress.
ErrorEstimate estimate_error_by(const Discretization& d, const CellStresses& stresses, VoigtColumns recovered_stress,
                                Estimator estimator) {
  const Mesh& mesh = d.mesh;
  const bool hexahedra = mesh.shape == CellShape::hexahedron;
  const Material& material = d.shapes.material();
  const Eigen::Index doubles_per_cell = 6 * quadrature_count(mesh.shape);

  ErrorEstimate estimate;
  estimate.nodal_stress = std::move(recovered_stress);
  estimate.eta.resize(mesh.cell_count());
  estimate.direction.resize(3, mesh.cell_count());
  const Eigen::Matrix<double, 8, Eigen::Dynamic> nodal = padded(estimate.nodal_stress);
  const auto estimate_cell = [&](int cell, CellGeometry& scratch) {
    std::array<Lanes, 8> recovered;
    const CellGeometry& geometry = d.shapes.geometry(mesh, cell, scratch);
    for (int c = 0; c < corner_count(mesh.shape); ++c) recovered[c] = nodal.col(mesh.cells[cell][c]);
    const double* stress = stresses.quadrature.data() + doubles_per_cell * cell;
    const double share = material_share(mesh, cell);
    const bool placed = share < 1.0 && !mesh.means.empty();
    const CellError error =
        !hexahedra ? tetrahedron_error(material, geometry, stress, recovered)
                   : hexahedron_error(material, geometry,
                                      placed ? weights_at_material(geometry, mesh.means[cell]) : geometry.weights,
                                      stress, recovered);
    const EdgeWeights edge =
        edge_weights(estimator == Estimator::spr_edges ? d.singular_edge[cell] : SingularEdge{}, material, mesh.shape);
    const double unresolved = std::min(edge.largest_gain * error.error_squared, edge.share_of_energy * error.energy);
    estimate.direction.col(cell) = error.direction;
    return Squares{share * (error.error_squared + unresolved), share * error.energy};
  };
  std::vector<Squares> squares(static_cast<std::size_t>(mesh.cell_count()));
  for_parts(mesh.cell_count(), worth_a_thread(200), [&](int first, int last) {
    CellGeometry scratch;
    for (int cell = first; cell < last; ++cell) squares[cell] = estimate_cell(cell, scratch);
  });
  if (estimator == Estimator::spr_edges) {
    if (!hexahedra) add_pollution(d.singular_edge, squares);
    const double factor = factor_for_amplitude(d, squares);
    for (Squares& of_cell : squares) of_cell.error *= factor;
  }
  double total_squared = 0.0, energy = 0.0;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    estimate.eta[cell] = std::sqrt(squares[cell].error);
    total_squared += squares[cell].error;
    energy += squares[cell].energy;
  }
  estimate.total = std::sqrt(total_squared);
  estimate.energy_norm = std::sqrt(energy);
  estimate.relative = energy > 0.0 ? estimate.total / estimate.energy_norm : 0.0;
  return estimate;
}

}  // namespace

double rim_energy_share(double exponent) { return std::exp(8.0 - 15.2 * exponent); }

TetrahedronWeights tetrahedra_notch_energy_share(double exponent) {
  return {std::exp(0.7 - 3.0 * exponent), std::exp(11.2 - 24.0 * exponent)};
}

double pollution_share(double exponent) { return 0.1 * std::exp(-10.0 * std::max(0.0, exponent - 0.5)); }

ErrorEstimate estimate_error_spr(const Discretization& d, const Eigen::Matrix3Xd& u) {
  return estimate_error(d, u, Estimator::spr);
}

ErrorEstimate estimate_error(const Discretization& d, const Eigen::Matrix3Xd& u, Estimator estimator) {
  const CellStresses stresses = cell_stresses(d, u);
  return estimate_error_by(d, stresses,
                           estimator == Estimator::spr ? recover_stress_spr(d, stresses)
                                                       : recover_stress_twice(d, stresses, free_directions(d, u)),
                           estimator);
}

}  // namespace finegauge
