#include "core/equilibrated_estimate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "core/elasticity/polynomial_cell.hpp"
#include "core/mesh/face_patches.hpp"
#include "core/solve/direct_solver.hpp"

namespace finegauge {

namespace {

using RigidModes = Eigen::Matrix<double, 3, 6>;

/// What the tractions of a patch may be changed in, and what they are.
struct PatchData {
  Eigen::Matrix3d held;  ///< projector onto the directions in which the traction is unknown
  struct Point {
    Eigen::Vector3d X;         ///< [m]
    double dA;                 ///< with the quadrature weight [m²]
    Eigen::Vector3d traction;  ///< on side 0 [Pa]
    double s, t;
  };
  std::vector<Point> points;
  double weight;  ///< of a change: area over volume [1/m]
};

/// Frame of a cell's rigid motions: translations, and rotations about its centre in units of its size.
struct CellFrame {
  Eigen::Vector3d centre;  ///< [m]
  double size;             ///< root of the mean squared distance of the corners from the centre [m]
  RigidModes at(const Eigen::Vector3d& X) const {
    const Eigen::Vector3d r = (X - centre) / size;
    RigidModes modes;
    modes.leftCols<3>().setIdentity();
    modes.rightCols<3>() << 0.0, r.z(), -r.y(), -r.z(), 0.0, r.x(), r.y(), -r.x(), 0.0;  // column k: e_k × r
    return modes;
  }
};

/// Directions that conditions on named surfaces hold, and tractions that loads put there.
struct SurfaceData {
  Eigen::Matrix3d held = Eigen::Matrix3d::Zero();
  Eigen::Vector3d traction = Eigen::Vector3d::Zero();
};

class Surfaces {
 public:
  Surfaces(const BaseMesh& base, const Mesh& mesh, const StaticProblem& problem) {
    for (const SupportCondition& condition : problem.supports) {
      Eigen::Matrix3d H = Eigen::Matrix3d::Identity();
      if (condition.normal) {
        const Eigen::Vector3d n = condition.normal->normalized();
        H = n * n.transpose();
      }
      for (const BaseFace& face : base.surfaces.at(condition.surface)) {
        Eigen::Matrix3d& held = data_[face].held;
        // The directions of both: the orthogonal complement of what neither holds.
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spectrum(held + H);
        Eigen::Matrix3d both = Eigen::Matrix3d::Zero();
        for (int k = 0; k < 3; ++k)
          if (spectrum.eigenvalues()[k] > 1e-9)
            both += spectrum.eigenvectors().col(k) * spectrum.eigenvectors().col(k).transpose();
        held = both;
      }
    }
    for (const SurfaceLoad& load : problem.loads) {
      Eigen::Vector3d traction = load.value;
      if (load.kind == LoadKind::total_by_area) traction /= area(base, mesh, load.surface);
      for (const BaseFace& face : base.surfaces.at(load.surface)) data_[face].traction += traction;
    }
  }
  SurfaceData at(const BaseFace& face) const {
    const auto found = data_.find(face);
    return found == data_.end() ? SurfaceData{} : found->second;
  }

 private:
  static double area(const BaseMesh& base, const Mesh& mesh, const std::string& surface) {
    // The load vector of unit tractions along x adds up to the area.
    return nodal_loads(base, mesh, {{surface, LoadKind::traction, Eigen::Vector3d::UnitX()}}).row(0).sum();
  }
  std::map<BaseFace, SurfaceData> data_;
};

/// Position and area vector (outward for side 0, with the measure of the unit square) of a patch's point.
struct PatchPlace {
  Eigen::Vector3d X, area;
};
PatchPlace place_of(const Mesh& mesh, const FacePatch& patch, double s, double t) {
  const FacePatch::Side& side = patch.sides[0];
  const Eigen::Vector3d xi = side.natural(s, t);
  const CellVectors corners = corner_values(mesh, side.cell, mesh.nodes);
  const auto N = shape_functions(CellShape::hexahedron, xi);
  PatchPlace place{Eigen::Vector3d::Zero(), {}};
  for (int c = 0; c < 8; ++c) place.X += N[c] * corners.col(c);
  const Eigen::Matrix3d J = corners * shape_gradients(CellShape::hexahedron, xi).transpose();
  // Nanson: the natural normal times cof J. The patch's own axes may run in either sense; its area is |s × t|.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  normal[side.face / 2] = side.face % 2 == 1 ? 1.0 : -1.0;
  const double natural_area = side.along_s.cross(side.along_t).norm();
  place.area = natural_area * J.determinant() * (J.inverse().transpose() * normal);
  return place;
}

constexpr int points_along_face = 4;

class Equilibration {
 public:
  Equilibration(const RefinementForest& forest, const Discretization& d, const StaticProblem& problem,
                const Eigen::Matrix<double, 6, Eigen::Dynamic>& recovered, const PolynomialCell& local)
      : mesh_(d.mesh), problem_(problem), local_(local), patches_(face_patches(forest.topology(), d.mesh)) {
    youngs_modulus_ = d.shapes.material().youngs_modulus;
    find_frames(d);
    find_tractions(Surfaces(forest.base(), d.mesh, problem), recovered);
    patches_of_.resize(mesh_.cell_count());
    for (std::size_t k = 0; k < patches_.size(); ++k)
      for (const FacePatch::Side& side : patches_[k].sides)
        if (side.cell >= 0) patches_of_[side.cell].push_back(static_cast<int>(k));
  }

  /// Changes the tractions; false when the system could not be factored.
  bool balance() {
    const Eigen::VectorXd before = resultants();
    const double scale = before.cwiseAbs().maxCoeff();
    build_pattern();
    BlockMatrix<double> A;
    A.reset(pattern_);
    for (std::size_t k = 0; k < patches_.size(); ++k) add_patch(A, k);
    const DirectSolver solver(A);
    if (!solver.factored()) return false;
    // Twice: the second solve takes what round-off left of the first.
    for (int pass = 0; pass < 2; ++pass) change_tractions(solver.solve(-resultants()));
    imbalance = scale > 0.0 ? resultants().cwiseAbs().maxCoeff() / scale : 0.0;
    correction = std::sqrt(correction_squared() / youngs_modulus_);
    return true;
  }

  /// ∫ N f dV + ∫ N F dA over the cell and its surface, 3 × nodes of the local cell [N].
  Eigen::Matrix3Xd local_loads(int cell, const CellVectors& corners) const {
    Eigen::Matrix3Xd loads = Eigen::Matrix3Xd::Zero(3, local_.node_count());
    if (problem_.body)
      for (const PolynomialCell::VolumePoint& point : local_.volume_points()) {
        const auto N = shape_functions(CellShape::hexahedron, point.xi);
        Eigen::Vector3d X = Eigen::Vector3d::Zero();
        for (int c = 0; c < 8; ++c) X += N[c] * corners.col(c);
        const Eigen::Matrix3d J = corners * shape_gradients(CellShape::hexahedron, point.xi).transpose();
        loads += point.weight * std::abs(J.determinant()) * problem_.body(X) * point.N.transpose();
      }
    for (const int k : patches_of_[cell])
      for (int i = 0; i < 2; ++i) {
        const FacePatch::Side& side = patches_[k].sides[i];
        if (side.cell != cell) continue;
        const double sign = i == 0 ? 1.0 : -1.0;
        for (const PatchData::Point& point : data_[k].points)
          loads +=
              sign * point.dA * point.traction * local_.shape_functions(side.natural(point.s, point.t)).transpose();
      }
    return loads;
  }

  double imbalance = 0.0, correction = 0.0;

 private:
  void find_frames(const Discretization& d) {
    CellGeometry scratch;
    for (int cell = 0; cell < mesh_.cell_count(); ++cell) {
      const CellVectors X = corner_values(mesh_, cell, mesh_.nodes);
      const Eigen::Vector3d centre = X.rowwise().mean();
      frames_.push_back({centre, std::sqrt((X.colwise() - centre).colwise().squaredNorm().mean())});
      volumes_.push_back(d.shapes.geometry(mesh_, cell, scratch).volume);
    }
  }

  void find_tractions(const Surfaces& surfaces, const Eigen::Matrix<double, 6, Eigen::Dynamic>& recovered) {
    const GaussRule rule = gauss_rule(points_along_face);
    for (const FacePatch& patch : patches_) {
      PatchData& data = data_.emplace_back();
      const bool boundary = patch.sides[1].cell < 0;
      SurfaceData given;
      given.held.setIdentity();
      if (boundary) given = surfaces.at(patch.base);
      data.held = given.held;
      double area = 0.0;
      for (int j = 0; j < points_along_face; ++j)
        for (int i = 0; i < points_along_face; ++i) {
          const double s = rule.points[i], t = rule.points[j];
          const PatchPlace place = place_of(mesh_, patch, s, t);
          const double measure = place.area.norm();
          const auto N = shape_functions(CellShape::hexahedron, patch.sides[0].natural(s, t));
          Voigt stress = Voigt::Zero();
          for (int c = 0; c < 8; ++c) stress += N[c] * recovered.col(mesh_.cells[patch.sides[0].cell][c]);
          const Eigen::Vector3d of_recovered = stress_tensor(stress) * place.area / measure;
          const Eigen::Vector3d traction = given.held * of_recovered + given.traction - given.held * given.traction;
          const double dA = rule.weights[i] * rule.weights[j] * measure;
          area += dA;
          data.points.push_back({place.X, dA, traction, s, t});
        }
      double thickness = volumes_[patch.sides[0].cell] / area;
      if (!boundary) thickness = 0.5 * (thickness + volumes_[patch.sides[1].cell] / area);
      data.weight = 1.0 / thickness;
    }
  }

  /// Force and moment (over the cell's size) on each cell, 6 per cell [N]: what the local loads do on rigid motions,
  /// which the local polynomials hold.
  Eigen::VectorXd resultants() const {
    Eigen::VectorXd b = Eigen::VectorXd::Zero(6 * static_cast<Eigen::Index>(mesh_.cell_count()));
    for (int cell = 0; cell < mesh_.cell_count(); ++cell) {
      const CellVectors corners = corner_values(mesh_, cell, mesh_.nodes);
      const Eigen::Matrix3Xd loads = local_loads(cell, corners), X = local_.interpolate(corners);
      for (Eigen::Index node = 0; node < X.cols(); ++node)
        b.segment<6>(6 * static_cast<Eigen::Index>(cell)) +=
            frames_[cell].at(X.col(node)).transpose() * loads.col(node);
    }
    return b;
  }

  /// Two blocks a cell: translation, rotation.
  void build_pattern() {
    std::vector<std::vector<int>> neighbours(mesh_.cell_count());
    for (int cell = 0; cell < mesh_.cell_count(); ++cell) neighbours[cell].push_back(cell);
    for (const FacePatch& patch : patches_) {
      if (patch.sides[1].cell < 0) continue;
      neighbours[patch.sides[0].cell].push_back(patch.sides[1].cell);
      neighbours[patch.sides[1].cell].push_back(patch.sides[0].cell);
    }
    pattern_ = {};
    pattern_.row_start.push_back(0);
    for (int cell = 0; cell < mesh_.cell_count(); ++cell) {
      std::vector<int>& others = neighbours[cell];
      std::ranges::sort(others);
      others.erase(std::unique(others.begin(), others.end()), others.end());
      for (int half = 0; half < 2; ++half) {
        for (const int other : others)
          for (int k = 0; k < 2; ++k) {
            if (2 * other + k == 2 * cell + half) pattern_.diagonal.push_back(pattern_.block_count());
            pattern_.column.push_back(2 * other + k);
          }
        pattern_.row_start.push_back(pattern_.block_count());
      }
    }
  }

  void add_block(BlockMatrix<double>& A, int row_cell, int column_cell, const Eigen::Matrix<double, 6, 6>& G) const {
    for (int half = 0; half < 2; ++half) {
      const int row = 2 * row_cell + half;
      const auto begin = pattern_.column.begin() + pattern_.row_start[row],
                 end = pattern_.column.begin() + pattern_.row_start[row + 1];
      const auto at = static_cast<int>(std::lower_bound(begin, end, 2 * column_cell) - pattern_.column.begin());
      A.block(at) += G.block<3, 3>(3 * half, 0);
      A.block(at + 1) += G.block<3, 3>(3 * half, 3);
    }
  }

  void add_patch(BlockMatrix<double>& A, std::size_t k) const {
    const PatchData& data = data_[k];
    std::array<std::array<Eigen::Matrix<double, 6, 6>, 2>, 2> G{};
    for (auto& row : G) row.fill(Eigen::Matrix<double, 6, 6>::Zero());
    const int sides = patches_[k].sides[1].cell < 0 ? 1 : 2;
    for (const PatchData::Point& point : data.points) {
      std::array<RigidModes, 2> modes;
      for (int i = 0; i < sides; ++i) modes[i] = frames_[patches_[k].sides[i].cell].at(point.X);
      for (int i = 0; i < sides; ++i)
        for (int j = 0; j < sides; ++j)
          G[i][j] += (i == j ? data.weight : -data.weight) * point.dA * (modes[i].transpose() * data.held * modes[j]);
    }
    for (int i = 0; i < sides; ++i)
      for (int j = 0; j < sides; ++j) add_block(A, patches_[k].sides[i].cell, patches_[k].sides[j].cell, G[i][j]);
  }

  void change_tractions(const Eigen::VectorXd& motions) {
    for (std::size_t k = 0; k < patches_.size(); ++k)
      for (PatchData::Point& point : data_[k].points) {
        point.traction += data_[k].weight * (data_[k].held * jump(k, point.X, motions));
      }
    motions_ = motions_.size() == 0 ? motions : Eigen::VectorXd(motions_ + motions);
  }

  Eigen::Vector3d jump(std::size_t k, const Eigen::Vector3d& X, const Eigen::VectorXd& motions) const {
    const auto& sides = patches_[k].sides;
    const auto motion = [&](int cell) { return motions.segment<6>(6 * static_cast<Eigen::Index>(cell)); };
    Eigen::Vector3d result = frames_[sides[0].cell].at(X) * motion(sides[0].cell);
    if (sides[1].cell >= 0) result -= frames_[sides[1].cell].at(X) * motion(sides[1].cell);
    return result;
  }

  double correction_squared() const {
    double sum = 0.0;
    for (std::size_t k = 0; k < patches_.size(); ++k)
      for (const PatchData::Point& point : data_[k].points)
        sum += point.dA * data_[k].weight * (data_[k].held * jump(k, point.X, motions_)).squaredNorm();
    return sum;
  }

  const Mesh& mesh_;
  const StaticProblem& problem_;
  const PolynomialCell& local_;
  double youngs_modulus_ = 0.0;
  std::vector<FacePatch> patches_;
  std::vector<PatchData> data_;
  std::vector<std::vector<int>> patches_of_;  // per cell
  std::vector<CellFrame> frames_;
  std::vector<double> volumes_;  // [m³]
  BlockPattern pattern_;
  Eigen::VectorXd motions_;
};

/// A local cell's stiffness, and the factor of it with its rigid motions held.
struct LocalSystem {
  Eigen::MatrixXd stiffness;
  Eigen::LLT<Eigen::MatrixXd> factor;
};

LocalSystem local_system(const PolynomialCell& local, const CellVectors& corners, const Material& material) {
  LocalSystem system{local.stiffness(corners, material), {}};
  const Eigen::Matrix3Xd X = local.interpolate(corners);
  const Eigen::Vector3d centre = X.rowwise().mean();
  const CellFrame frame{centre, std::sqrt((X.colwise() - centre).colwise().squaredNorm().mean())};
  Eigen::MatrixXd modes(3 * X.cols(), 6);
  for (Eigen::Index i = 0; i < X.cols(); ++i) modes.middleRows<3>(3 * i) = frame.at(X.col(i));
  const Eigen::MatrixXd Q =
      Eigen::HouseholderQR<Eigen::MatrixXd>(modes).householderQ() * Eigen::MatrixXd::Identity(modes.rows(), 6);
  system.factor.compute(system.stiffness + system.stiffness.diagonal().mean() * (Q * Q.transpose()));
  return system;
}

/// Systems of cells that are translates of one another are one. Few are kept: a mesh has few shapes, or as many as
/// cells.
class LocalSystems {
  using Key = std::array<std::int64_t, 22>;  // seven corners from the first, in units of 2^-36 of the size; the unit

 public:
  LocalSystems(const PolynomialCell& local, const Material& material) : local_(local), material_(material) {}
  const LocalSystem& of(const CellVectors& corners) {
    Key key;
    const int exponent = std::ilogb((corners.col(7) - corners.col(0)).norm()) - 36;
    const double unit = std::ldexp(1.0, exponent);
    key[21] = exponent;
    for (int c = 1; c < 8; ++c)
      for (int i = 0; i < 3; ++i) key[3 * (c - 1) + i] = std::llround((corners(i, c) - corners(i, 0)) / unit);
    const auto found = systems_.find(key);
    if (found != systems_.end()) return found->second;
    if (systems_.size() >= 32) systems_.clear();
    return systems_.emplace(key, local_system(local_, corners, material_)).first->second;
  }

 private:
  const PolynomialCell& local_;
  const Material& material_;
  std::map<Key, LocalSystem> systems_;
};

/// ∫ (σ_w - σ_h):C⁻¹:(σ_w - σ_h) [J], for a solution whose dilatation is the cell's mean: there ε_h is not the strain
/// of its stress, and as nu -> 1/2 all of the distance of strains would be that difference.
double distance_from_mean_dilatation(const PolynomialCell& local, const CellVectors& corners, const CellVectors& u,
                                     const CellGeometry& geometry, const Eigen::Matrix3Xd& w,
                                     const Material& material) {
  const double dilatation = u.cwiseProduct(geometry.mean_gradients).sum();
  const auto points = static_cast<Eigen::Index>(local.volume_points().size());
  Eigen::VectorXd divergence(points), deviatoric(points), volumes(points);
  for (Eigen::Index q = 0; q < points; ++q) {
    const PolynomialCell::VolumePoint& point = local.volume_points()[static_cast<std::size_t>(q)];
    const Eigen::Matrix<double, 3, 8> dN = shape_gradients(CellShape::hexahedron, point.xi);
    const Eigen::Matrix3d J = corners * dN.transpose(), to_space = J.inverse().transpose();
    const Eigen::Matrix3d H_w = w * (to_space * point.dN_dxi).transpose();
    const Eigen::Matrix3d H = H_w - u * (to_space * dN).transpose();
    const Eigen::Matrix3d strain = 0.5 * (H + H.transpose());
    divergence[q] = H_w.trace();
    deviatoric[q] = (strain - strain.trace() / 3.0 * Eigen::Matrix3d::Identity()).squaredNorm();
    volumes[q] = point.weight * std::abs(J.determinant());
  }
  const Eigen::VectorXd volumetric = local.projected(corners, divergence).array() - dilatation;
  return volumes.dot(2.0 * material.mu() * deviatoric + material.bulk() * volumetric.cwiseAbs2());
}

/// The recovered stress; with Dilatation::mean its pressure is that of linear polynomials. The energy of a pressure
/// is small as nu -> 1/2, but not that of the shear which it causes in a cell when it is wrong by much.
VoigtColumns recovered_for_tractions(const Discretization& d, const Eigen::Matrix3Xd& u, const ErrorEstimate& spr) {
  VoigtColumns stress = spr.nodal_stress;
  if (d.shapes.material().dilatation != Dilatation::mean) return stress;
  const VoigtColumns linear = recover_stress_spr(d, cell_stresses(d, u), PatchBasis::linear);
  const Eigen::RowVectorXd change = (linear.topRows<3>().colwise().sum() - stress.topRows<3>().colwise().sum()) / 3.0;
  stress.topRows<3>().rowwise() += change;
  return stress;
}

std::string why_not(const RefinementForest& forest, const Discretization& d, const StaticProblem& problem) {
  if (d.mesh.shape != CellShape::hexahedron) return "equilibrated tractions are for hexahedra";
  if (d.shapes.material().kinematics != Kinematics::linear) return "equilibrated tractions are for linear kinematics";
  if (!d.mesh.fraction.empty()) return "equilibrated tractions are for cells that are full of material";
  if (!problem.springs.empty()) return "equilibrated tractions know no springs";
  for (const SupportCondition& condition : problem.supports)
    if (!forest.base().surfaces.contains(condition.surface))
      return "equilibrated tractions know supports of surfaces only, not of the region '" + condition.surface + "'";
  for (const SurfaceLoad& load : problem.loads)
    if (load.kind == LoadKind::total_by_node)
      return "a total force shared by nodes has no traction, so there is none to be in equilibrium with";
  return "";
}

}  // namespace

EquilibratedEstimate estimate_error_equilibrated(const RefinementForest& forest, const Discretization& d,
                                                 const StaticProblem& problem, const Eigen::Matrix3Xd& u,
                                                 const ErrorEstimate& spr, const EquilibratedOptions& options) {
  EquilibratedEstimate estimate;
  estimate.why_not = why_not(forest, d, problem);
  if (!estimate.exists()) return estimate;
  const PolynomialCell local(options.degree);
  Equilibration equilibration(forest, d, problem, recovered_for_tractions(d, u, spr), local);
  if (!equilibration.balance()) {
    estimate.why_not = "the system that balances the cells could not be factored: is the body held?";
    return estimate;
  }
  estimate.imbalance = equilibration.imbalance;
  estimate.correction = equilibration.correction;
  estimate.eta.resize(d.mesh.cell_count());
  LocalSystems systems(local, d.shapes.material());
  const Material& material = d.shapes.material();
  CellGeometry scratch;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const CellVectors corners = corner_values(d.mesh, cell, d.mesh.nodes);
    const LocalSystem& system = systems.of(corners);
    if (system.factor.info() != Eigen::Success) {
      estimate = {};
      estimate.why_not = "the local problem of cell " + std::to_string(cell) + " could not be factored";
      return estimate;
    }
    const Eigen::Matrix3Xd loads = equilibration.local_loads(cell, corners);
    const Eigen::Matrix3Xd here = local.interpolate(corner_values(d.mesh, cell, u));
    const Eigen::Map<const Eigen::VectorXd> F(loads.data(), loads.size()), u_h(here.data(), here.size());
    const Eigen::VectorXd stretched = system.stiffness * u_h;
    const Eigen::VectorXd difference = system.factor.solve(F - stretched);
    double squared = difference.dot(system.stiffness * difference);
    if (material.dilatation == Dilatation::mean) {
      const Eigen::VectorXd sum = u_h + difference;
      const Eigen::Map<const Eigen::Matrix3Xd> w(sum.data(), 3, local.node_count());
      squared = distance_from_mean_dilatation(local, corners, corner_values(d.mesh, cell, u),
                                              d.shapes.geometry(d.mesh, cell, scratch), w, material);
    }
    estimate.eta[cell] = std::sqrt(squared < 0.0 ? 0.0 : squared);  // what is no number stays none
  }
  estimate.total = estimate.eta.norm();
  estimate.relative = spr.energy_norm > 0.0 ? estimate.total / spr.energy_norm : 0.0;
  if (!std::isfinite(estimate.total)) estimate = {.eta = {}, .why_not = "the local problems have no finite solution"};
  return estimate;
}

}  // namespace finegauge
