#include "benchmarks/paper/phantom_table.hpp"

#include <cmath>
#include <cstdio>

namespace finegauge {

std::string short_number(double value, const char* format) {
  if (!std::isfinite(value)) return "-";
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

Plot phantom_force_plot(const PhantomComparison& comparison) {
  Plot plot;
  plot.file = "force_" + to_string(comparison.setting) + ".svg";
  plot.title = "Force over travel of the tip, puncture strength " + short_number(comparison.setting.puncture) +
               " N, friction " + short_number(comparison.setting.friction);
  plot.x_label = "travel of the tip since first touch [mm]";
  plot.y_label = "needle-tissue force along the axis [N]";
  plot.log_x = plot.log_y = false;
  for (const auto& [mesh, one] : comparison.cases) {
    PlotSeries series{mesh, {}, {}};
    for (std::size_t k = 0; k < one.curve.travel.size(); ++k) {
      series.x.push_back(1e3 * one.curve.travel[k]);
      series.y.push_back(one.curve.force[k]);
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

Plot phantom_dofs_plot(const std::vector<PhantomComparison>& comparisons) {
  Plot plot;
  plot.file = "dofs.svg";
  plot.title = "Degrees of freedom during the insertion, adaptive mesh";
  plot.x_label = "time [s]";
  plot.y_label = "degrees of freedom";
  plot.log_x = plot.log_y = false;
  for (const PhantomComparison& comparison : comparisons) {
    PlotSeries series{
        short_number(comparison.setting.puncture) + " N, μ " + short_number(comparison.setting.friction), {}, {}};
    for (const MotionFrame& frame : comparison.cases.at("adaptive").run.frames) {
      series.x.push_back(frame.report.frame.time);
      series.y.push_back(frame.report.frame.dofs);
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

std::vector<ComparisonRow> phantom_table(const std::vector<PhantomComparison>& comparisons, const PhantomRates& best,
                                         const std::optional<PhantomRates>& plain, const PaperNumbers& paper) {
  std::vector<ComparisonRow> rows;
  for (const PhantomComparison& c : comparisons) {
    const std::string name = short_number(c.setting.puncture) + " N, μ " + short_number(c.setting.friction) + ": ";
    const auto two = [](double coarse, double adaptive) {
      return "coarse " + short_number(coarse) + ", adaptive " + short_number(adaptive);
    };
    if (c.setting.puncture > 0.0) {
      rows.push_back({name + "stiffness [kN/m]", paper("stiffness"),
                      two(1e-3 * c.stiffness("coarse"), 1e-3 * c.stiffness("adaptive")) + ", nested " +
                          short_number(1e-3 * c.stiffness("nested")),
                      "before puncture; the paper shows curves only", paper.place("stiffness")});
      if (c.cases.contains("fine"))
        rows.push_back({name + "the same, paper's fine mesh", paper("stiffness"),
                        short_number(1e-3 * c.stiffness("fine")),
                        "20x10x10 nodes are not nested in 10x5x5: the needle runs through cells, not along nodes",
                        paper.place("stiffness")});
    }
    rows.push_back({name + "envelope off by [%]", paper("force"),
                    two(100.0 * c.envelope("coarse"), 100.0 * c.envelope("adaptive")),
                    "from the nested fine mesh; clamping, speed and length of a cut are ours (phantom.toml)",
                    paper.place("force")});
    rows.push_back({name + "force off by [%]", paper("force"), two(100.0 * c.rms("coarse"), 100.0 * c.rms("adaptive")),
                    "RMS over travel; the phase of stick and cut dominates it", paper.place("force")});
    rows.push_back({name + "mean dofs", paper("dofs"),
                    "adaptive " + short_number(c.cases.at("adaptive").mean_dofs, "%.0f") + ", nested " +
                        short_number(c.cases.at("nested").mean_dofs, "%.0f"),
                    "", paper.place("dofs")});
  }
  const std::string papers_rates =
      paper("frames_per_second_adaptive") + " / " + paper("frames_per_second_fine") + " = " +
      short_number(paper.value("frames_per_second_adaptive") / paper.value("frames_per_second_fine"), "%.2g");
  const auto add_rates = [&](const std::string& solver, const PhantomRates& r) {
    rows.push_back(
        {"frames/s, " + solver + ", adaptive / nested", papers_rates,
         short_number(r.adaptive) + " / " + short_number(r.nested) + " = " + short_number(r.ratio()),
         "the paper's include drawing, on another machine, over its own fine mesh: only ratios compare; ours "
         "of the mean dofs is " +
             short_number(r.dofs_ratio),
         paper.place("frames_per_second_adaptive")});
  };
  if (plain) add_rates("plain CG", *plain);
  add_rates("best solver", best);
  return rows;
}

}  // namespace finegauge
