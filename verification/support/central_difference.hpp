#pragma once

namespace finegauge {

/// f'(0) by central differences, extrapolated once (error h⁴).
template <class Function>
auto difference(const Function& f, double h) {
  using Value = decltype(f(h));
  const Value near = (f(h) - f(-h)) / (2.0 * h), far = (f(2.0 * h) - f(-2.0 * h)) / (4.0 * h);
  return Value((4.0 * near - far) / 3.0);
}
/// For functions that change at the scale of one: h⁴ = 1e-12 and round-off 1e-16 / h = 1e-13 of the value.
constexpr double difference_step = 1e-3;

}  // namespace finegauge
