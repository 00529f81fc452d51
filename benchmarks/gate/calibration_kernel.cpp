#include "benchmarks/gate/calibration_kernel.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "benchmarks/gate/rank_statistics.hpp"
#include "benchmarks/program/processor_time.hpp"
#include "core/stopwatch.hpp"

namespace finegauge {
namespace {

constexpr int nodes_x = 12, nodes_yz = 7, cells = 368, iterations = 10;
constexpr int node_count = nodes_x * nodes_yz * nodes_yz;
constexpr std::size_t factor_length = std::size_t{1} << 19;  // doubles: 4 MiB

/// A fixed sequence that looks like no pattern, in [0, 1).
struct Sequence {
  std::uint64_t state = 0x9e3779b97f4a7c15;
  double next() {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state >> 11) * 0x1p-53;
  }
};

}  // namespace

struct CalibrationKernel::Work {
  std::vector<int> row_start, column;
  std::vector<Eigen::Matrix3d> block;
  std::vector<double> x, b, r, p, Ap;
  std::array<std::array<Eigen::Matrix3d, 64>, 4> stiffness;  // rest shapes of the cells
  std::vector<Eigen::Matrix3d> rotation;
  std::vector<double> factor, eta;
  std::vector<int> order;

  Work() {
    Sequence random;
    const auto number = [](int i, int j, int k) { return i + nodes_x * (j + nodes_yz * k); };
    row_start.push_back(0);
    for (int k = 0; k < nodes_yz; ++k)
      for (int j = 0; j < nodes_yz; ++j)
        for (int i = 0; i < nodes_x; ++i) {
          for (int c = std::max(0, k - 1); c <= std::min(nodes_yz - 1, k + 1); ++c)
            for (int d = std::max(0, j - 1); d <= std::min(nodes_yz - 1, j + 1); ++d)
              for (int a = std::max(0, i - 1); a <= std::min(nodes_x - 1, i + 1); ++a) {
                const bool diagonal = a == i && d == j && c == k;
                column.push_back(number(a, d, c));
                // Diagonally dominant, and symmetric since the rest is one number: conjugate gradients converge.
                block.push_back(diagonal ? Eigen::Matrix3d(30.0 * Eigen::Matrix3d::Identity())
                                         : Eigen::Matrix3d(Eigen::Matrix3d::Constant(-1.0 / 3.0)));
              }
          row_start.push_back(static_cast<int>(column.size()));
        }
    for (std::vector<double>* vector : {&x, &b, &r, &p, &Ap}) vector->resize(3 * node_count);
    for (double& value : b) value = random.next() - 0.5;
    for (auto& cell : stiffness)
      for (Eigen::Matrix3d& of_corners : cell)
        for (double& value : of_corners.reshaped()) value = random.next() - 0.5;
    for (int cell = 0; cell < cells; ++cell)
      rotation.emplace_back(
          Eigen::AngleAxisd(random.next(), Eigen::Vector3d(random.next(), random.next(), 1.0).normalized()));
    factor.resize(factor_length);
    for (double& value : factor) value = random.next();
    eta.resize(cells);
    for (double& value : eta) value = random.next();
    order.resize(cells);
  }

  void multiply() {
    for (int row = 0; row < node_count; ++row) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int at = row_start[row]; at < row_start[row + 1]; ++at)
        sum += block[at] * Eigen::Vector3d::Map(&p[3 * static_cast<std::size_t>(column[at])]);
      Eigen::Vector3d::Map(&Ap[3 * static_cast<std::size_t>(row)]) = sum;
    }
  }

  double solve() {
    std::ranges::fill(x, 0.0);
    r = b;
    p = r;
    double rr = std::inner_product(r.begin(), r.end(), r.begin(), 0.0);
    for (int iteration = 0; iteration < iterations; ++iteration) {
      multiply();
      const double alpha = rr / std::inner_product(p.begin(), p.end(), Ap.begin(), 0.0);
      for (std::size_t i = 0; i < x.size(); ++i) {
        x[i] += alpha * p[i];
        r[i] -= alpha * Ap[i];
      }
      const double next = std::inner_product(r.begin(), r.end(), r.begin(), 0.0);
      for (std::size_t i = 0; i < x.size(); ++i) p[i] = r[i] + next / rr * p[i];
      rr = next;
    }
    return std::accumulate(x.begin(), x.end(), std::sqrt(rr));
  }

  double assemble() const {
    double sum = 0.0;
    for (int cell = 0; cell < cells; ++cell) {
      const auto& K = stiffness[static_cast<std::size_t>(cell) % stiffness.size()];
      const Eigen::Matrix3d& R = rotation[static_cast<std::size_t>(cell)];
      Eigen::Matrix3d turned = Eigen::Matrix3d::Zero();
      for (const Eigen::Matrix3d& of_corners : K) turned += R * of_corners * R.transpose();
      sum += turned(cell % 3, (cell / 3) % 3);
    }
    return sum;
  }

  double substitute() const {
    // Four sums side by side, so that memory and not a chain of additions is what it waits for.
    std::array<double, 4> sum{};
    for (std::size_t i = 0; i < factor.size(); i += 4)
      for (std::size_t lane = 0; lane < 4; ++lane) sum[lane] += factor[i + lane] * b[(i / 64 + lane) % b.size()];
    return sum[0] + sum[1] + sum[2] + sum[3];
  }

  double mark() {
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, {}, [&](int cell) { return eta[static_cast<std::size_t>(cell)]; });
    return order[cells / 2];
  }
};

CalibrationKernel::CalibrationKernel() : work_(std::make_unique<Work>()) { expected_ = frame(); }
CalibrationKernel::~CalibrationKernel() = default;

double CalibrationKernel::frame() {
  const double solved = work_->solve();
  return solved + work_->assemble() + work_->substitute() + work_->mark();
}

KernelTime CalibrationKernel::measure(int frames) {
  std::vector<double> wall, processor;
  const int warm_up = frames / 10;
  for (int i = -warm_up; i < frames; ++i) {
    const double before = processor_ms();
    Stopwatch watch;
    const double result = frame();
    const double ms = watch.lap();
    if (result != expected_) throw std::runtime_error("the calibration kernel has another result than before");
    if (i < 0) continue;
    wall.push_back(ms);
    processor.push_back(processor_ms() - before);
  }
  return {median(std::move(wall)), median(std::move(processor))};
}

}  // namespace finegauge
