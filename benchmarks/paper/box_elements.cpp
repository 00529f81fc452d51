#include "benchmarks/paper/box_elements.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "core/solve/direct_solver.hpp"
#include "core/space/assembly.hpp"

namespace finegauge {
namespace {

/// Integrals of the Lagrange polynomials on [0, 1] and of their derivatives.
struct Interval {
  Eigen::VectorXd nodes;      ///< Chebyshev points, both ends included; the space does not depend on the choice
  Eigen::VectorXd load;       ///< ∫ N_a
  Eigen::MatrixXd mass;       ///< ∫ N_a N_b
  Eigen::MatrixXd advection;  ///< ∫ N_a' N_b
  Eigen::MatrixXd stiffness;  ///< ∫ N_a' N_b'
};

Interval integrate_interval(int order) {
  const int n = order + 1;
  Interval interval;
  interval.nodes.resize(n);
  for (int i = 0; i < n; ++i) interval.nodes[i] = 0.5 - 0.5 * std::cos(std::numbers::pi * i / order);
  interval.nodes[0] = 0.0, interval.nodes[order] = 1.0;
  // n Gauss points are exact to degree 2 n - 1 > 2 order. Points and weights from the Jacobi matrix of the Legendre
  // polynomials (Golub & Welsch 1969).
  Eigen::MatrixXd jacobi = Eigen::MatrixXd::Zero(n, n);
  for (int k = 1; k < n; ++k) jacobi(k, k - 1) = jacobi(k - 1, k) = k / std::sqrt(4.0 * k * k - 1.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> gauss(jacobi);
  interval.load = Eigen::VectorXd::Zero(n);
  interval.mass = interval.advection = interval.stiffness = Eigen::MatrixXd::Zero(n, n);
  for (int q = 0; q < n; ++q) {
    const double at = 0.5 + 0.5 * gauss.eigenvalues()[q];
    const double weight = std::pow(gauss.eigenvectors()(0, q), 2);  // those of [-1, 1] are twice this
    Eigen::VectorXd N = Eigen::VectorXd::Ones(n), dN = Eigen::VectorXd::Zero(n);
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b) {
        if (b == a) continue;
        const double gap = interval.nodes[a] - interval.nodes[b];
        dN[a] = (dN[a] * (at - interval.nodes[b]) + N[a]) / gap;  // product rule, factor by factor
        N[a] *= (at - interval.nodes[b]) / gap;
      }
    interval.load += weight * N;
    interval.mass += weight * N * N.transpose();
    interval.advection += weight * dN * N.transpose();
    interval.stiffness += weight * dN * dN.transpose();
  }
  return interval;
}

/// Nodes and cells by lattice, x fastest; lattice nodes without a cell have no number.
struct Grid {
  std::array<int, 3> cells, nodes;        ///< per axis
  std::vector<std::array<int, 3>> kept;   ///< cells
  std::vector<int> number;                ///< per lattice node, -1 without a cell
  std::vector<std::array<int, 3>> place;  ///< lattice indices per numbered node

  int lattice(const std::array<int, 3>& at) const { return at[0] + nodes[0] * (at[1] + nodes[1] * at[2]); }
};

Grid number_grid(const BoxElementProblem& problem) {
  Grid grid;
  for (int axis = 0; axis < 3; ++axis) {
    grid.cells[axis] = static_cast<int>(problem.coordinates[axis].size()) - 1;
    grid.nodes[axis] = grid.cells[axis] * problem.order + 1;
  }
  const auto removed = [&](const std::array<int, 3>& cell) {
    if (!problem.removed) return false;
    for (int axis = 0; axis < 3; ++axis)
      if (cell[axis] < problem.removed->first[axis] || cell[axis] >= problem.removed->last[axis]) return false;
    return true;
  };
  grid.number.assign(static_cast<std::size_t>(grid.nodes[0]) * grid.nodes[1] * grid.nodes[2], -1);
  const int order = problem.order;
  for (int k = 0; k < grid.cells[2]; ++k)
    for (int j = 0; j < grid.cells[1]; ++j)
      for (int i = 0; i < grid.cells[0]; ++i) {
        if (removed({i, j, k})) continue;
        grid.kept.push_back({i, j, k});
        for (int c = 0; c <= order; ++c)
          for (int b = 0; b <= order; ++b)
            for (int a = 0; a <= order; ++a)
              grid.number[grid.lattice({i * order + a, j * order + b, k * order + c})] = 0;
      }
  for (int k = 0; k < grid.nodes[2]; ++k)
    for (int j = 0; j < grid.nodes[1]; ++j)
      for (int i = 0; i < grid.nodes[0]; ++i) {
        int& number = grid.number[grid.lattice({i, j, k})];
        if (number < 0) continue;
        number = static_cast<int>(grid.place.size());
        grid.place.push_back({i, j, k});
      }
  return grid;
}

/// The cell's nodes, x fastest.
std::vector<int> cell_nodes(const Grid& grid, int order, const std::array<int, 3>& cell) {
  std::vector<int> nodes;
  nodes.reserve((order + 1) * (order + 1) * (order + 1));
  for (int c = 0; c <= order; ++c)
    for (int b = 0; b <= order; ++b)
      for (int a = 0; a <= order; ++a)
        nodes.push_back(grid.number[grid.lattice({cell[0] * order + a, cell[1] * order + b, cell[2] * order + c})]);
  return nodes;
}

/// Every pair of nodes that share a cell.
BlockPattern couple(const Grid& grid, int order) {
  const int n = static_cast<int>(grid.place.size());
  std::vector<std::vector<int>> cells_of(n);
  for (std::size_t e = 0; e < grid.kept.size(); ++e)
    for (const int node : cell_nodes(grid, order, grid.kept[e])) cells_of[node].push_back(static_cast<int>(e));
  BlockPattern pattern;
  pattern.row_start.push_back(0);
  std::vector<int> row;
  for (int i = 0; i < n; ++i) {
    row.clear();
    for (const int e : cells_of[i]) {
      const std::vector<int> nodes = cell_nodes(grid, order, grid.kept[e]);
      row.insert(row.end(), nodes.begin(), nodes.end());
    }
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    const auto diagonal = std::lower_bound(row.begin(), row.end(), i) - row.begin();
    pattern.diagonal.push_back(pattern.row_start.back() + static_cast<int>(diagonal));
    pattern.column.insert(pattern.column.end(), row.begin(), row.end());
    pattern.row_start.push_back(static_cast<int>(pattern.column.size()));
  }
  return pattern;
}

Eigen::Vector3d cell_size(const BoxElementProblem& problem, const std::array<int, 3>& cell) {
  Eigen::Vector3d h;
  for (int axis = 0; axis < 3; ++axis)
    h[axis] = problem.coordinates[axis][cell[axis] + 1] - problem.coordinates[axis][cell[axis]];
  return h;
}

/// Block (a, b) of a cell's stiffness. With g_ij = ∫ ∂_i N_a ∂_j N_b, a product of integrals along the axes, it is
/// lambda g_ij + mu g_ji + mu δ_ij tr g.
Eigen::Matrix3d stiffness_block(const Interval& interval, const Material& material, const Eigen::Vector3d& h,
                                const std::array<int, 3>& a, const std::array<int, 3>& b) {
  Eigen::Matrix3d g;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      double product = 1.0;
      for (int axis = 0; axis < 3; ++axis) {
        if (axis == i && axis == j)
          product *= interval.stiffness(a[axis], b[axis]) / h[axis];
        else if (axis == i)
          product *= interval.advection(a[axis], b[axis]);
        else if (axis == j)
          product *= interval.advection(b[axis], a[axis]);
        else
          product *= interval.mass(a[axis], b[axis]) * h[axis];
      }
      g(i, j) = product;
    }
  return material.lambda() * g + material.mu() * g.transpose() +
         material.mu() * g.trace() * Eigen::Matrix3d::Identity();
}

void assemble(const BoxElementProblem& problem, const Grid& grid, const Interval& interval, BlockMatrix<double>& A,
              Eigen::VectorXd& loads) {
  const int n = problem.order + 1;
  std::vector<std::array<int, 3>> local;
  for (int c = 0; c < n; ++c)
    for (int b = 0; b < n; ++b)
      for (int a = 0; a < n; ++a) local.push_back({a, b, c});
  for (const std::array<int, 3>& cell : grid.kept) {
    const Eigen::Vector3d h = cell_size(problem, cell);
    const std::vector<int> nodes = cell_nodes(grid, problem.order, cell);
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      const auto row = A.pattern->column.begin() + A.pattern->row_start[nodes[a]];
      const auto row_end = A.pattern->column.begin() + A.pattern->row_start[nodes[a] + 1];
      for (std::size_t b = 0; b < nodes.size(); ++b) {
        const auto position = std::lower_bound(row, row_end, nodes[b]) - A.pattern->column.begin();
        A.block(static_cast<int>(position)) += stiffness_block(interval, problem.material, h, local[a], local[b]);
      }
      if (cell[0] == 0 && local[a][0] == 0)
        loads.segment<3>(3 * nodes[a]) +=
            h.y() * h.z() * interval.load[local[a][1]] * interval.load[local[a][2]] * problem.traction;
    }
  }
}

Supports find_held(const BoxElementProblem& problem, const Grid& grid, const Interval& interval) {
  Supports supports;
  for (std::size_t node = 0; node < grid.place.size(); ++node) {
    Eigen::Vector3d X;
    for (int axis = 0; axis < 3; ++axis) {
      const int at = grid.place[node][axis], cell = at / problem.order, within = at % problem.order;
      const std::vector<double>& x = problem.coordinates[axis];
      X[axis] = within == 0 ? x[cell] : x[cell] + interval.nodes[within] * (x[cell + 1] - x[cell]);
    }
    const std::array<bool, 3> held = problem.held(X);
    if (!held[0] && !held[1] && !held[2]) continue;
    supports.reduced.push_back(static_cast<int>(node));
    supports.held.push_back(
        Eigen::Vector3d(held[0] ? 1.0 : 0.0, held[1] ? 1.0 : 0.0, held[2] ? 1.0 : 0.0).asDiagonal());
    supports.displacement.emplace_back(Eigen::Vector3d::Zero());
  }
  return supports;
}

}  // namespace

BoxElementSolution solve_box_elements(const BoxElementProblem& problem) {
  if (problem.order < 1 || problem.order > 8)
    throw std::invalid_argument("order of the elements is " + std::to_string(problem.order) +
                                ", but must be between 1 and 8");
  const Interval interval = integrate_interval(problem.order);
  const Grid grid = number_grid(problem);
  const BlockPattern pattern = couple(grid, problem.order);
  const Supports supports = find_held(problem, grid, interval);
  BlockMatrix<double> A;
  A.reset(pattern);
  Eigen::VectorXd loads = Eigen::VectorXd::Zero(3 * pattern.size());
  assemble(problem, grid, interval, A, loads);
  apply_supports(supports, A);
  project(supports, loads);

  const DirectSolver solver(A);
  if (!solver.factored()) throw std::runtime_error("reference solution: the body is not held");
  const Eigen::VectorXd x = solver.solve(loads);
  Eigen::VectorXd Ax;
  multiply(A, x, Ax);
  BoxElementSolution solution;
  solution.cells = static_cast<int>(grid.kept.size());
  solution.dofs = 3 * pattern.size();
  solution.energy = 2.0 * loads.dot(x) - x.dot(Ax);  // the algebraic error enters squared
  solution.relative_residual = (loads - Ax).norm() / loads.norm();
  return solution;
}

}  // namespace finegauge
