#include "core/elasticity/cell_response.hpp"

#include <cmath>

#include "core/elasticity/rotation.hpp"

namespace finegauge {

namespace {

/// Σ_a u_a g_aᵀ: the gradient of a field from its corner values.
Eigen::Matrix3d field_gradient(const CellVectors& u, const Gradients& g) {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  for (int a = 0; a < max_corners; ++a)
    for (int k = 0; k < 3; ++k) H.col(k) += g(k, a) * u.col(a);
  return H;
}

double divergence(const CellVectors& u, const Gradients& g) { return u.cwiseProduct(g).sum(); }

/// Global stress from the local displacement turned by R: `turned` = R local, so that H = turned gᵀ is R ∇u and
/// H Rᵀ is R ∇u Rᵀ. The pressure does not turn.
struct StressLaw {
  double two_mu, lambda, bulk_times_mean;
  bool mean, turns;

  StressLaw(const CellGeometry& geometry, const Material& material, const CellVectors& local)
      : two_mu(2.0 * material.mu()),
        lambda(material.lambda()),
        bulk_times_mean(0.0),
        mean(material.dilatation == Dilatation::mean),
        turns(material.kinematics == Kinematics::corotational) {
    if (mean) bulk_times_mean = material.bulk() * divergence(local, geometry.mean_gradients);
  }

  Voigt operator()(const CellVectors& turned, const Gradients& g, const Eigen::Matrix3d& R) const {
    Eigen::Matrix3d H = field_gradient(turned, g);
    if (turns) H = Eigen::Matrix3d(H * R.transpose());
    const double trace = H.trace();
    const double pressure = mean ? bulk_times_mean - two_mu / 3.0 * trace : lambda * trace;
    Voigt sigma;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      sigma[i] = two_mu * H(i, i) + pressure;
      sigma[3 + i] = 0.5 * two_mu * (H(i, j) + H(j, i));
    }
    return sigma;
  }

  CellVectors turn(const Eigen::Matrix3d& R, const CellVectors& local) const {
    if (!turns) return local;
    return R.lazyProduct(local);
  }
};

}  // namespace

Eigen::Matrix3d cell_rotation(const CellGeometry& geometry, const Material& material, const CellVectors& x) {
  if (material.kinematics == Kinematics::linear) return Eigen::Matrix3d::Identity();
  // Gradients sum to zero; measured from a corner, a far-away cell keeps its digits.
  CellVectors from_corner = x;
  from_corner.colwise() -= x.col(0).eval();
  return nearest_rotation(field_gradient(from_corner, geometry.centre_gradients));
}

CellVectors cell_force(const CellMatrix& stiffness, const Eigen::Matrix3d& R, const CellVectors& X,
                       const CellVectors& x) {
  // Measured from a corner, which changes nothing (K has no translation force) but the round-off of far-away cells.
  // The unused corners of a tetrahedron meet the zero rows and columns of K.
  const Eigen::Vector3d X0 = X.col(0), x0 = x.col(0);
  const Eigen::Matrix3d Rt = R.transpose();
  CellVectors local;
  for (int a = 0; a < max_corners; ++a) local.col(a) = Rt * (x.col(a) - x0) - (X.col(a) - X0);
  CellVectors force;
  Eigen::Map<const Eigen::Matrix<double, 24, 1>> u(local.data());
  Eigen::Map<Eigen::Matrix<double, 24, 1>> f(force.data());
  f.noalias() = stiffness.lazyProduct(u);
  return R.lazyProduct(force);
}

Voigt centre_stress(CellShape /*shape*/, const CellGeometry& geometry, const Material& material,
                    const Eigen::Matrix3d& R, const CellVectors& local) {
  const StressLaw law(geometry, material, local);
  return law(law.turn(R, local), geometry.centre_gradients, R);
}

Eigen::Matrix<double, 6, 8> quadrature_stress(CellShape shape, const CellGeometry& geometry, const Material& material,
                                              const Eigen::Matrix3d& R, const CellVectors& local) {
  const StressLaw law(geometry, material, local);
  const CellVectors turned = law.turn(R, local);
  Eigen::Matrix<double, 6, 8> stress;
  if (shape == CellShape::tetrahedron) stress.setZero();
  for (int q = 0; q < quadrature_count(shape); ++q) stress.col(q) = law(turned, geometry.gradients[q], R);
  return stress;
}

double complementary_product(const Material& material, const Voigt& sigma, const Voigt& tau) {
  const double nu = material.poisson_ratio;
  const double product = sigma.head<3>().dot(tau.head<3>()) + 2.0 * sigma.tail<3>().dot(tau.tail<3>());
  return ((1.0 + nu) * product - nu * sigma.head<3>().sum() * tau.head<3>().sum()) / material.youngs_modulus;
}

double von_mises(const Voigt& s) {
  const double xy = s[0] - s[1], yz = s[1] - s[2], zx = s[2] - s[0];
  return std::sqrt(0.5 * (xy * xy + yz * yz + zx * zx) + 3.0 * s.tail<3>().squaredNorm());
}

Voigt voigt(const Eigen::Matrix3d& S) {
  return (Voigt() << S(0, 0), S(1, 1), S(2, 2), S(0, 1), S(1, 2), S(2, 0)).finished();
}

Eigen::Matrix3d stress_tensor(const Voigt& s) {
  Eigen::Matrix3d S;
  S << s[0], s[3], s[5],  //
      s[3], s[1], s[4],   //
      s[5], s[4], s[2];
  return S;
}

Voigt rotate_stress(const Eigen::Matrix3d& R, const Voigt& s) { return voigt(R * stress_tensor(s) * R.transpose()); }

}  // namespace finegauge
