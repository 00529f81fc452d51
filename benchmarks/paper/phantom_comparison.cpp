#include "benchmarks/paper/phantom_comparison.hpp"

#include <algorithm>
#include <cstdio>

namespace finegauge {

PhantomSettings phantom_settings(const PaperNumbers& paper) {
  PhantomSettings settings;
  settings.middle = {paper.value("puncture_strength_of_frictions"), paper.value("friction_of_puncture_strengths")};
  const auto add = [&](const PhantomSetting& setting) {
    if (std::ranges::find(settings.all, setting) == settings.all.end()) settings.all.push_back(setting);
  };
  for (const double puncture : paper.values("puncture_strengths")) add({puncture, settings.middle.friction});
  for (const double friction : paper.values("frictions")) add({settings.middle.puncture, friction});
  return settings;
}

std::string to_string(const PhantomSetting& setting) {
  char text[48];
  std::snprintf(text, sizeof text, "puncture_%gN_friction_%g", setting.puncture, setting.friction);
  return text;
}

PhantomRates rates(const PhantomComparison& comparison) {
  const NeedleCase &adaptive = comparison.cases.at("adaptive"), &nested = comparison.cases.at("nested");
  return {adaptive.frames_per_second(), nested.frames_per_second(), nested.mean_dofs / adaptive.mean_dofs};
}

PhantomRates median_rates(std::vector<PhantomRates> passes) {
  const auto middle = passes.begin() + static_cast<std::ptrdiff_t>((passes.size() - 1) / 2);
  std::nth_element(passes.begin(), middle, passes.end(),
                   [](const PhantomRates& a, const PhantomRates& b) { return a.ratio() < b.ratio(); });
  return *middle;
}

Json rate_check(const PhantomRates& rates) {
  return check("frame_rate_ratio.best", rates.ratio(), rates.dofs_ratio, rates.dofs_ratio * rates.dofs_ratio);
}

}  // namespace finegauge
