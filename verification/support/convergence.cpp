#include "verification/support/convergence.hpp"

#include <gsl/gsl_fit.h>

#include <cmath>
#include <iomanip>
#include <sstream>
#include <stdexcept>

namespace finegauge {

namespace {

void check(const ErrorSeries& series) {
  if (series.h.size() != series.error.size() || series.h.size() < 2)
    throw std::invalid_argument(series.quantity + ": an order needs two grids, each with its error");
  for (std::size_t i = 0; i < series.h.size(); ++i) {
    const bool sound = std::isfinite(series.h[i]) && series.h[i] > 0.0 && std::isfinite(series.error[i]) &&
                       series.error[i] > 0.0 && (i == 0 || series.h[i] < series.h[i - 1]);
    if (!sound) {
      std::ostringstream message;
      message << series.quantity << ": grid " << i << " has h = " << series.h[i] << " and error " << series.error[i]
              << ", but both must be positive and finite and h must fall";
      throw std::invalid_argument(message.str());
    }
  }
}

double order_between(const ErrorSeries& series, std::size_t coarse) {
  return std::log(series.error[coarse] / series.error[coarse + 1]) / std::log(series.h[coarse] / series.h[coarse + 1]);
}

}  // namespace

double last_order(const ErrorSeries& series) {
  check(series);
  return order_between(series, series.h.size() - 2);
}

double fitted_order(const ErrorSeries& series) {
  check(series);
  std::vector<double> log_h, log_error;
  for (const double h : series.h) log_h.push_back(std::log(h));
  for (const double error : series.error) log_error.push_back(std::log(error));
  double intercept, slope, cov00, cov01, cov11, residual;
  gsl_fit_linear(log_h.data(), 1, log_error.data(), 1, log_h.size(), &intercept, &slope, &cov00, &cov01, &cov11,
                 &residual);
  return slope;
}

std::string convergence_table(const std::vector<ErrorSeries>& series) {
  std::ostringstream text;
  if (series.empty()) return {};
  text << '\n' << std::setw(9) << "h";
  for (const ErrorSeries& s : series) text << std::setw(11) << s.quantity << std::setw(6) << "order";
  for (std::size_t i = 0; i < series.front().h.size(); ++i) {
    text << '\n' << std::setw(9) << std::setprecision(4) << std::defaultfloat << series.front().h[i];
    for (const ErrorSeries& s : series) {
      text << std::setw(11) << std::scientific << std::setprecision(3) << s.error[i] << std::setw(6);
      if (i == 0)
        text << "";
      else
        text << std::fixed << std::setprecision(3) << order_between(s, i - 1);
    }
  }
  text << '\n';
  if (series.front().h.size() > 1) {
    text << std::setw(9) << "all grids";
    for (const ErrorSeries& s : series)
      text << std::setw(11) << "" << std::setw(6) << std::fixed << std::setprecision(3) << fitted_order(s);
    text << '\n';
  }
  return text.str();
}

}  // namespace finegauge
