#pragma once

#include <string>
#include <vector>

namespace finegauge {

/// An error on a sequence of grids, coarsest first.
struct ErrorSeries {
  std::string quantity;
  std::vector<double> h;      ///< mesh size [m], > 0
  std::vector<double> error;  ///< > 0
};

/// log(e_i / e_{i+1}) / log(h_i / h_{i+1}) of the last two grids. Throws std::invalid_argument unless there are two,
/// with positive, finite and differing sizes and positive, finite errors: a vanishing error has no order.
double last_order(const ErrorSeries& series);
/// The least-squares slope of log e over log h on all grids.
double fitted_order(const ErrorSeries& series);
/// Grids by rows, per quantity the error and the order from the grid before: the message of a test that fails.
std::string convergence_table(const std::vector<ErrorSeries>& series);

}  // namespace finegauge
