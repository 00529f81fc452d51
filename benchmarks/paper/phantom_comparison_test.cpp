#include "benchmarks/paper/phantom_comparison.hpp"

#include <limits>

#include "verification/support/catch.hpp"

using namespace finegauge;

TEST_CASE("the phantom's settings are the paper's two scenarios, each once", "[paper]") {
  const PhantomSettings settings = phantom_settings(paper_numbers("phantom"));
  CHECK(settings.middle == PhantomSetting{10.0, 0.5});
  CHECK(settings.all == std::vector<PhantomSetting>{{0.0, 0.5}, {10.0, 0.5}, {20.0, 0.5}, {10.0, 0.1}, {10.0, 0.3}});
}

TEST_CASE("the median of passes is the pass in the middle, whole", "[paper]") {
  const auto pass = [](double adaptive, double nested) { return PhantomRates{adaptive, nested, 2.5}; };
  CHECK(median_rates({pass(100, 10), pass(90, 30), pass(80, 20)}).nested == 20.0);
  CHECK(median_rates({pass(100, 10), pass(90, 30)}).nested == 30.0);
  CHECK(median_rates({pass(100, 10)}).nested == 10.0);
}

TEST_CASE("a ratio of frame rates is at least that of the dofs and no more than its square", "[paper]") {
  const auto holds = [](double ratio) { return all_checks_hold(Json::array({rate_check({ratio, 1.0, 2.5})})); };
  CHECK(holds(2.5));
  CHECK(holds(3.0));
  CHECK(holds(6.25));
  CHECK_FALSE(holds(2.4));
  CHECK_FALSE(holds(6.4));
  CHECK_FALSE(holds(std::numeric_limits<double>::quiet_NaN()));
}
