#include "verification/support/exact_field.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "core/adapt/stress_recovery.hpp"
#include "core/elasticity/polynomial_cell.hpp"
#include "verification/support/field_errors.hpp"

namespace finegauge {

namespace {

using Complex = std::complex<double>;

/// φ = a z^λ, ψ = b z^λ.
struct Potentials {
  double lambda;
  Complex a, b;
};

/// In the corner's frame the bisector is the real axis; the cut of z^λ runs opposite to it.
ExactField potentials_field(const std::string& name, const Potentials& p, const Eigen::Vector2d& at, double bisector,
                            const Material& material) {
  const Complex turn = std::polar(1.0, bisector);
  const auto local = [=](const Eigen::Vector3d& X) {
    return (Complex(X.x(), X.y()) - Complex(at.x(), at.y())) * std::conj(turn);
  };
  const auto displacement = [=](const Eigen::Vector3d& X) -> Eigen::Vector3d {
    const Complex z = local(X);
    if (z == Complex(0.0)) return Eigen::Vector3d::Zero();
    const double kappa = 3.0 - 4.0 * material.poisson_ratio;
    const Complex power = std::pow(z, p.lambda), phi = p.a * power, dphi = p.lambda * phi / z, psi = p.b * power;
    const Complex u = turn * (kappa * phi - z * std::conj(dphi) - std::conj(psi)) / (2.0 * material.mu());
    return {u.real(), u.imag(), 0.0};
  };
  const auto stress = [=](const Eigen::Vector3d& X) -> Voigt {
    const Complex z = local(X), power = std::pow(z, p.lambda - 1.0);
    const Complex dphi = p.lambda * p.a * power, ddphi = (p.lambda - 1.0) * dphi / z, dpsi = p.lambda * p.b * power;
    const double sum = 4.0 * dphi.real();
    // σ_yy - σ_xx + 2 i σ_xy turns with exp(-2 i angle) of the frame.
    const Complex difference = 2.0 * (std::conj(z) * ddphi + dpsi) * std::conj(turn) * std::conj(turn);
    Voigt s;
    s << 0.5 * (sum - difference.real()), 0.5 * (sum + difference.real()), material.poisson_ratio * sum,
        0.5 * difference.imag(), 0.0, 0.0;
    return s;
  };
  return {name, displacement, stress, {}, at};
}

/// At r = 1, of (Re a, Im a, Re b, Im b): no resultant φ + z φ'̄ + ψ̄ on the free face at `half`, no displacement on
/// the clamped one at -half.
Eigen::Matrix4d clamped_corner_conditions(double lambda, double half, const Material& material) {
  const double kappa = 3.0 - 4.0 * material.poisson_ratio;
  Eigen::Matrix4d conditions;
  for (int k = 0; k < 4; ++k) {
    const Complex a = k == 0 ? Complex(1.0, 0.0) : k == 1 ? Complex(0.0, 1.0) : Complex(0.0);
    const Complex b = k == 2 ? Complex(1.0, 0.0) : k == 3 ? Complex(0.0, 1.0) : Complex(0.0);
    const auto parts = [&](double angle) {
      const Complex z = std::polar(1.0, angle), power = std::polar(1.0, lambda * angle);
      return std::pair(a * power, z * std::conj(lambda * a * power / z) + std::conj(b * power));
    };
    const auto [phi_free, rest_free] = parts(half);
    const auto [phi_clamped, rest_clamped] = parts(-half);
    const Complex free = phi_free + rest_free, clamped = kappa * phi_clamped - rest_clamped;
    conditions.col(k) << free.real(), free.imag(), clamped.real(), clamped.imag();
  }
  return conditions;
}

/// A root between two places where f has different signs.
template <class F>
double bisect(const F& f, double low, double high) {
  const bool rises = f(high) > 0.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    ((f(middle) > 0.0) == rises ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

double exponent_equation(CornerMode mode, double opening, double lambda) {
  const double sign = mode == CornerMode::opening ? 1.0 : -1.0;
  return std::sin(opening * lambda) + sign * lambda * std::sin(opening);
}

/// A rectangle of the natural coordinates ξ and η of a cell, all of ζ.
struct Rectangle {
  Eigen::Vector2d low, size;
};

/// What a cell needs to be integrated over.
struct CellAtPoint {
  const Discretization& d;
  const ExactField& exact;
  const Eigen::Matrix<double, 6, Eigen::Dynamic>& recovered;
  int cell;
  CellVectors X, u;
  Gradients mean_gradients;
  double error = 0.0, energy = 0.0, recovered_error = 0.0;  ///< sums of squares

  void add(const Eigen::Vector3d& xi, double weight) {
    const auto N = shape_functions(CellShape::hexahedron, xi);
    const Eigen::Matrix<double, 3, 8> dN = shape_gradients(CellShape::hexahedron, xi);
    const Eigen::Matrix3d J = X * dN.transpose();
    const double dV = weight * J.determinant();
    const Gradients gradients = J.inverse().transpose() * dN;
    Eigen::Vector3d at = Eigen::Vector3d::Zero();
    Voigt interpolated = Voigt::Zero();
    for (int c = 0; c < 8; ++c) {
      at += N[c] * X.col(c);
      interpolated += N[c] * recovered.col(d.mesh.cells[cell][c]);
    }
    const Material& material = d.shapes.material();
    const Voigt sigma = exact.stress(at);
    const Voigt difference = discrete_stress(material, u, gradients, mean_gradients) - sigma;
    error += dV * complementary_product(material, difference, difference);
    energy += dV * complementary_product(material, sigma, sigma);
    interpolated -= sigma;
    recovered_error += dV * complementary_product(material, interpolated, interpolated);
  }

  void integrate(const Rectangle& r, const GaussRule& rule) {
    const std::size_t n = rule.points.size();
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t j = 0; j < n; ++j)
        for (std::size_t i = 0; i < n; ++i)
          add({r.low.x() + r.size.x() * rule.points[i], r.low.y() + r.size.y() * rule.points[j], rule.points[k]},
              rule.weights[i] * rule.weights[j] * rule.weights[k] * r.size.x() * r.size.y());
  }

  /// Nearest distance, in the plane, of the rectangle's corners at ζ = 1/2 to the line, and the rectangle's diameter.
  std::array<double, 2> distance_and_size(const Rectangle& r) const {
    std::array<Eigen::Vector2d, 4> corner;
    double nearest = std::numeric_limits<double>::infinity();
    for (int c = 0; c < 4; ++c) {
      const auto N = shape_functions(CellShape::hexahedron, {r.low.x() + ((c & 1) ? r.size.x() : 0.0),
                                                             r.low.y() + ((c & 2) ? r.size.y() : 0.0), 0.5});
      Eigen::Vector3d at = Eigen::Vector3d::Zero();
      for (int a = 0; a < 8; ++a) at += N[a] * X.col(a);
      corner[c] = at.head<2>();
      nearest = std::min(nearest, (corner[c] - *exact.singular_line).norm());
    }
    return {nearest, std::max((corner[3] - corner[0]).norm(), (corner[2] - corner[1]).norm())};
  }

  /// Quarters that touch the line are split again; the last one, 2^-24 of the cell, holds
  /// 1e-7 of its energy where λ is a half, 5e-5 where it is 0.3.
  void integrate_towards_line(const Rectangle& r, const GaussRule& rule, int level) {
    const auto [distance, size] = distance_and_size(r);
    if (level == 24 || distance > 0.4 * size) {
      integrate(r, rule);
      return;
    }
    for (int q = 0; q < 4; ++q) {
      const Eigen::Vector2d half = 0.5 * r.size;
      integrate_towards_line({r.low + half.cwiseProduct(Eigen::Vector2d(q & 1, q >> 1)), half}, rule, level + 1);
    }
  }
};

/// Of one tetrahedron, whose stress is constant: sums of squares as in CellAtPoint.
struct TetrahedronSums {
  double error = 0.0, energy = 0.0, recovered_error = 0.0;
};

/// With s from the part of the tetrahedron on the line to the part opposite, r is proportional to s. After s = t^4 an
/// integrand r^(2 λ - 2) is t^(8 λ - 1), which eight points integrate to 3e-5 for λ above a quarter.
TetrahedronSums integrate_tetrahedron(const Discretization& d, const ExactField& exact, int cell, const Voigt& stress,
                                      const Eigen::Matrix<double, 6, Eigen::Dynamic>& recovered,
                                      const GaussRule& rule) {
  const Eigen::Matrix<double, 3, 4> X = corner_values(d.mesh, cell, d.mesh.nodes).leftCols<4>();
  const Material& material = d.shapes.material();
  const auto on_line = [&](int corner) {
    return exact.singular_line && (X.col(corner).head<2>() - *exact.singular_line).norm() < 1e-9 * X.norm();
  };
  std::array<int, 4> order = {0, 1, 2, 3};  // those on the line first
  const auto touching = std::stable_partition(order.begin(), order.end(), on_line) - order.begin();
  if (touching > 2) throw std::invalid_argument("true_error: a tetrahedron has three corners on the singular line");
  const double six_volumes = std::abs((X.col(1) - X.col(0)).dot((X.col(2) - X.col(0)).cross(X.col(3) - X.col(0))));
  const int power = touching > 0 ? 4 : 1;
  const GaussRule from_line = touching > 0 ? gauss_rule(8) : rule;
  TetrahedronSums sums;
  const std::size_t n = rule.points.size();
  for (std::size_t i = 0; i < from_line.points.size(); ++i)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = 0; k < n; ++k) {
        const double t = from_line.points[i], s = std::pow(t, power), a = rule.points[j], b = rule.points[k];
        std::array<double, 4> N;
        double weight =
            from_line.weights[i] * rule.weights[j] * rule.weights[k] * power * std::pow(t, power - 1) * six_volumes;
        if (touching == 2) {  // from an edge to the opposite one
          N = {(1.0 - s) * (1.0 - a), (1.0 - s) * a, s * (1.0 - b), s * b};
          weight *= s * (1.0 - s);
        } else {  // from a corner to the opposite face
          N = {1.0 - s, s * (1.0 - a), s * a * (1.0 - b), s * a * b};
          weight *= s * s * a;
        }
        Eigen::Vector3d at = Eigen::Vector3d::Zero();
        Voigt interpolated = Voigt::Zero();
        for (int c = 0; c < 4; ++c) {
          at += N[c] * X.col(order[c]);
          interpolated += N[c] * recovered.col(d.mesh.cells[cell][order[c]]);
        }
        const Voigt sigma = exact.stress(at), off = stress - sigma;
        interpolated -= sigma;
        sums.error += weight * complementary_product(material, off, off);
        sums.energy += weight * complementary_product(material, sigma, sigma);
        sums.recovered_error += weight * complementary_product(material, interpolated, interpolated);
      }
  return sums;
}

}  // namespace

ExactField exact_field(const ManufacturedSolution& solution, const Material& material) {
  return {solution.name,
          [solution](const Eigen::Vector3d& X) { return displacement(solution, X); },
          [solution, material](const Eigen::Vector3d& X) { return stress(solution, material, X); },
          [solution, material](const Eigen::Vector3d& X) { return body_force(solution, material, X); },
          {}};
}

double corner_exponent(CornerMode mode, double opening) {
  if (!(opening > std::numbers::pi && opening <= 2.0 * std::numbers::pi))
    throw std::invalid_argument("corner_exponent: the opening must be above pi and at most 2 pi");
  // λ = 1 always solves the sliding mode (a rotation); the root sought lies between 1/2 and there.
  const double step = 1e-3;
  for (double low = 0.5 - 0.5 * step; low < 1.0 - 2.0 * step; low += step) {
    const auto equation = [&](double lambda) { return exponent_equation(mode, opening, lambda); };
    if (equation(low) * equation(low + step) <= 0.0) return bisect(equation, low, low + step);
  }
  throw std::invalid_argument("corner_exponent: no singular term of this mode at this opening");
}

ExactField corner_field(CornerMode mode, double opening, const Eigen::Vector2d& at, double bisector,
                        const Material& material) {
  const double lambda = corner_exponent(mode, opening);
  const bool symmetric = mode == CornerMode::opening;
  const Complex a = symmetric ? Complex(1.0, 0.0) : Complex(0.0, 1.0);
  const double b_size = symmetric ? -(std::cos(opening * lambda) + lambda * std::cos(opening))
                                  : std::cos(opening * lambda) - lambda * std::cos(opening);
  return potentials_field(std::string(symmetric ? "opening" : "sliding") + " corner", {lambda, a, b_size * a}, at,
                          bisector, material);
}

ExactField clamped_corner_field(double free_face, double clamped_face, const Eigen::Vector2d& at,
                                const Material& material, double* exponent) {
  const double bisector = 0.5 * (free_face + clamped_face), half = 0.5 * (free_face - clamped_face);
  const auto determinant = [&](double lambda) {
    return clamped_corner_conditions(lambda, half, material).determinant();
  };
  const double step = 1e-3;
  for (double low = 0.3; low < 1.0 - 2.0 * step; low += step) {
    if (determinant(low) * determinant(low + step) > 0.0) continue;
    const double lambda = bisect(determinant, low, low + step);
    // What the conditions leave free: the last right singular vector.
    const Eigen::JacobiSVD<Eigen::Matrix4d> svd(clamped_corner_conditions(lambda, half, material), Eigen::ComputeFullV);
    const Eigen::Vector4d v = svd.matrixV().col(3);
    if (exponent) *exponent = lambda;
    return potentials_field("clamped corner", {lambda, {v[0], v[1]}, {v[2], v[3]}}, at, bisector, material);
  }
  throw std::invalid_argument("clamped_corner_field: no real exponent below one at this opening");
}

TrueError true_error(const Discretization& d, const ExactField& exact, const Eigen::Matrix3Xd& u,
                     const Eigen::Matrix<double, 6, Eigen::Dynamic>& recovered, int points_per_axis) {
  if (d.shapes.material().kinematics != Kinematics::linear)
    throw std::invalid_argument("true_error: linear kinematics only");
  const GaussRule rule = gauss_rule(points_per_axis);
  TrueError result;
  result.cell.resize(d.mesh.cell_count());
  double energy = 0.0, recovered_error = 0.0;
  const bool tetrahedra = d.mesh.shape == CellShape::tetrahedron;
  const CellStresses stresses = tetrahedra ? cell_stresses(d, u) : CellStresses{};
  CellGeometry scratch;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    if (tetrahedra) {
      const TetrahedronSums sums = integrate_tetrahedron(d, exact, cell, stresses.centre.col(cell), recovered, rule);
      result.cell[cell] = std::sqrt(sums.error);
      energy += sums.energy;
      recovered_error += sums.recovered_error;
      continue;
    }
    CellAtPoint at{d,
                   exact,
                   recovered,
                   cell,
                   corner_values(d.mesh, cell, d.mesh.nodes),
                   corner_values(d.mesh, cell, u),
                   d.shapes.geometry(d.mesh, cell, scratch).mean_gradients};
    const Rectangle whole{Eigen::Vector2d::Zero(), Eigen::Vector2d::Ones()};
    if (exact.singular_line)
      at.integrate_towards_line(whole, rule, 0);
    else
      at.integrate(whole, rule);
    result.cell[cell] = std::sqrt(at.error);
    energy += at.energy;
    recovered_error += at.recovered_error;
  }
  result.total = result.cell.norm();
  result.energy_norm = std::sqrt(energy);
  result.recovered = std::sqrt(recovered_error);
  return result;
}

}  // namespace finegauge
