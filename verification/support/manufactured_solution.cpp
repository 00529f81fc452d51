#include "verification/support/manufactured_solution.hpp"

#include <numbers>

namespace finegauge {

namespace {

using std::numbers::pi;

Jets smooth_formula(const Jets& x) {
  const Jet u = sin(pi * x[0]) * cos(pi * x[1]) * exp(0.5 * x[2]);
  const Jet v = cos(pi * x[0]) * sin(pi * x[2]) + x[0] * x[1] * x[2];
  const Jet w = sin(pi * (x[0] + x[1])) * x[2] * x[2];
  return {0.1 * u, 0.1 * v, 0.1 * w};
}

Jets isochoric_formula(const Jets& x) {
  const Jets s = {sin(pi * x[0]), sin(pi * x[1]), sin(pi * x[2])};
  const Jets c = {cos(pi * x[0]), cos(pi * x[1]), cos(pi * x[2])};
  const Jet psi_x = pi * c[0] * s[1] * s[2], psi_y = pi * s[0] * c[1] * s[2], psi_z = pi * s[0] * s[1] * c[2];
  return {0.1 * (psi_y - psi_z), 0.1 * (psi_z - psi_x), 0.1 * (psi_x - psi_y)};
}

}  // namespace

Eigen::Vector3d displacement(const ManufacturedSolution& solution, const Eigen::Vector3d& X) {
  const Jets u = solution.formula(coordinates_at(X));
  return {u[0].value, u[1].value, u[2].value};
}

Voigt stress(const ManufacturedSolution& solution, const Material& material, const Eigen::Vector3d& X) {
  const Jets u = solution.formula(coordinates_at(X));
  Eigen::Matrix3d gradient;
  for (int i = 0; i < 3; ++i) gradient.row(i) = u[i].gradient.transpose();
  const Eigen::Matrix3d sigma = material.mu() * (gradient + gradient.transpose()) +
                                material.lambda() * gradient.trace() * Eigen::Matrix3d::Identity();
  Voigt voigt;
  voigt << sigma(0, 0), sigma(1, 1), sigma(2, 2), sigma(0, 1), sigma(1, 2), sigma(2, 0);
  return voigt;
}

Eigen::Vector3d body_force(const ManufacturedSolution& solution, const Material& material, const Eigen::Vector3d& X) {
  const Jets u = solution.formula(coordinates_at(X));
  Eigen::Vector3d force;
  for (int i = 0; i < 3; ++i) {
    double gradient_of_divergence = 0.0;
    for (int j = 0; j < 3; ++j) gradient_of_divergence += u[j].hessian(j, i);
    force[i] = -(material.lambda() + material.mu()) * gradient_of_divergence - material.mu() * u[i].hessian.trace();
  }
  return force;
}

std::vector<SupportCondition> held_all_around(const ManufacturedSolution& solution) {
  std::vector<SupportCondition> supports;
  for (const char* surface : {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"})
    supports.push_back(
        {surface, std::nullopt, [solution](const Eigen::Vector3d& X) { return displacement(solution, X); }, {}});
  return supports;
}

ManufacturedSolution smooth_solution() { return {"smooth", smooth_formula}; }
ManufacturedSolution isochoric_solution() { return {"isochoric", isochoric_formula}; }

}  // namespace finegauge
