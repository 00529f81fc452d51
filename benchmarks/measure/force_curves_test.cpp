#include "benchmarks/measure/force_curves.hpp"

#include <algorithm>
#include <cmath>

#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

/// Rises with `stiffness` to 10 N, falls to half, then saw teeth of width 1 mm whose peaks grow by `slope` N a metre.
ForceCurve saw(double stiffness, double slope, double phase = 0.0) {
  ForceCurve curve;
  const double puncture = 10.0 / stiffness;
  for (int k = 0; k <= 3000; ++k) {
    const double x = 1e-5 * k;
    curve.travel.push_back(x);
    if (x <= puncture) {
      curve.force.push_back(stiffness * x);
      if (1e-5 * (k + 1) > puncture) curve.puncture = k;
      continue;
    }
    const double tooth = (x + phase) / 1e-3, share = tooth - std::floor(tooth);
    const double peak = 10.0 + slope * x;
    curve.force.push_back(peak * (0.5 + 0.5 * share));
    if (share > 0.985) curve.peaks.push_back({x, curve.force.back()});
  }
  return curve;
}

}  // namespace

TEST_CASE("stiffness before puncture is the slope of the rise", "[force curves]") {
  CHECK_THAT(stiffness_before_puncture(saw(5000.0, 100.0)), WithinRel(5000.0, 1e-9));
  ForceCurve none = saw(5000.0, 100.0);
  none.puncture = -1;
  CHECK(std::isnan(stiffness_before_puncture(none)));
}

TEST_CASE("the envelope knows nothing of the phase of stick and cut, the curve does", "[force curves]") {
  const ForceCurve a = saw(5000.0, 100.0), b = saw(5000.0, 100.0, 4e-4);
  CHECK(envelope_distance(a, b) < 0.01);
  CHECK(envelope_distance(a, b) > 0.0);
  CHECK(rms_distance(a, b) > 0.1);
  CHECK(rms_distance(a, a) == 0.0);
}

TEST_CASE("a higher envelope is measured as such", "[force curves]") {
  ForceCurve a = saw(5000.0, 100.0), b = a;
  for (double& force : a.force) force *= 1.1;
  for (ForcePeak& peak : a.peaks) peak.force *= 1.1;
  CHECK_THAT(envelope_distance(a, b), WithinAbs(0.1, 1e-12));
  CHECK_THAT(rms_distance(a, b), WithinAbs(0.1, 1e-12));
}

TEST_CASE("a peak is found between the frames that enclose it", "[force curves]") {
  const ForcePeak peak = passing_point(-1.0, {0.001, 12.0}, 1.0, {0.002, 14.0});
  CHECK_THAT(peak.travel, WithinAbs(0.0015, 1e-12));
  CHECK_THAT(peak.force, WithinAbs(13.0, 1e-12));
  CHECK(passing_point(0.5, {0.001, 12.0}, 1.0, {0.002, 14.0}).force == 14.0);  // it had passed before
}

TEST_CASE("a loop takes what lies between its two ways, and each way is a curve of its own", "[force curves]") {
  // In at 3 N over 0.04 m, out at -1 N: 4 N times 0.04 m.
  ForceCurve loop;
  for (int k = 0; k <= 40; ++k) loop.travel.push_back(1e-3 * k), loop.force.push_back(3.0);
  for (int k = 40; k >= 0; --k) loop.travel.push_back(1e-3 * k), loop.force.push_back(-1.0);
  CHECK_THAT(loop_area(loop), WithinAbs(0.16, 1e-12));
  const ForceCurve in = way_in(loop), back = way_back(loop);
  CHECK(in.travel.size() == 41);
  CHECK(in.travel.back() == 0.04);
  CHECK(back.travel.front() == 0.0);
  CHECK(std::ranges::is_sorted(back.travel));
  CHECK(back.force.front() == -1.0);
  CHECK_THAT(force_difference(in, way_in(loop)), WithinAbs(0.0, 0.0));
  CHECK_THAT(force_difference(in, back), WithinRel(4.0, 0.02));  // but for the turn, where the force jumps
  CHECK(std::isnan(force_difference(in, {})));
}
