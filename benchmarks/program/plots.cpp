#include "benchmarks/program/plots.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <system_error>

#include "benchmarks/program/atomic_file.hpp"

extern char** environ;

namespace finegauge {
namespace {

// Okabe & Ito 2008, "Color universal design": told apart with any common colour blindness. Yellow is left out, which
// is too light for a line on white.
constexpr std::array<const char*, 7> palette = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                "#56B4E9", "#E69F00", "#000000"};
constexpr std::array<int, 7> point_types = {7, 5, 9, 13, 11, 4, 6};  // a second mark beside the colour

struct Point {
  double x, y;
};

std::vector<Point> drawable_points(const PlotSeries& series, bool log_x, bool log_y) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
    const double x = series.x[i], y = series.y[i];
    if (std::isfinite(x) && std::isfinite(y) && (!log_x || x > 0.0) && (!log_y || y > 0.0)) points.push_back({x, y});
  }
  return points;
}

std::string number(double value, const char* format = "%.9g") {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// A double-quoted gnuplot string, shown as it is written: no escapes and (with noenhanced text) no markup.
std::string gnuplot_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out + "\"";
}

/// "20,000", "0.05", "2e-09".
std::string tick_label(double value) {
  if (value < 1000.0 || value >= 1e9) return number(value, "%g");
  std::string text = number(value, "%.0f");
  for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, ",");
  return text;
}

struct EndLabel {
  std::size_t series;
  double x, y;              // data
  double shown_x, shown_y;  // share of the axis, 0 to 1
};

/// Moves labels apart that would be drawn over one another. Shares of the axes; labels to the right of their points.
void spread(std::vector<EndLabel>& labels) {
  constexpr double label_width = 0.2, label_height = 0.05;
  std::sort(labels.begin(), labels.end(), [](const EndLabel& a, const EndLabel& b) { return a.shown_y < b.shown_y; });
  for (std::size_t i = 1; i < labels.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (std::abs(labels[i].shown_x - labels[j].shown_x) < label_width)
        labels[i].shown_y = std::max(labels[i].shown_y, labels[j].shown_y + label_height);
}

struct Axis {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  bool logarithmic;

  void include(double value) { low = std::min(low, value), high = std::max(high, value); }
  double scale(double value) const { return logarithmic ? std::log10(value) : value; }
  /// Room beside the data; more on the right, where the labels stand.
  void widen(double below, double above) {
    if (!(low <= high)) low = high = 1.0;
    double a = scale(low), b = scale(high);
    if (!(b - a > 1e-12 * std::max(1.0, std::abs(a)))) a -= 0.5, b += 0.5;
    const double range = b - a;
    a -= below * range, b += above * range;
    low = logarithmic ? std::pow(10.0, a) : a, high = logarithmic ? std::pow(10.0, b) : b;
  }
  double share(double value) const { return (scale(value) - scale(low)) / (scale(high) - scale(low)); }
  /// Ticks of a logarithmic axis: decades only where there are many, else some in each.
  std::string ticks(const char* name) const {
    if (!logarithmic) return {};
    const double decades = std::log10(high / low);
    std::string list;
    int count = 0;
    const auto add = [&](double value) {
      if (value < low || value > high) return;
      list += (list.empty() ? "" : ", ") + gnuplot_string(tick_label(value)) + " " + number(value);
      ++count;
    };
    const std::vector<int> steps = decades > 2.4   ? std::vector<int>{1}
                                   : decades > 1.3 ? std::vector<int>{1, 2, 5}
                                                   : std::vector<int>{1, 2, 3, 4, 5, 6, 8};
    for (int e = static_cast<int>(std::floor(std::log10(low))); e <= std::ceil(std::log10(high)); ++e)
      for (const int step : steps) add(step * std::pow(10.0, e));
    if (count < 2) {
      // Over so short a part of a decade a linear division is as good.
      list.clear();
      const double wanted = (high - low) / 4.0, digit = std::pow(10.0, std::floor(std::log10(wanted)));
      const double step = digit * (wanted < 2.0 * digit ? 1.0 : wanted < 5.0 * digit ? 2.0 : 5.0);
      for (double k = std::ceil(low / step); k * step <= high; ++k) add(k * step);
    }
    return "set " + std::string(name) + "tics (" + list + ")\nset m" + name + "tics default\n";
  }
};

/// The corner of the drawing in which the legend covers least of the curves; points in shares of the axes.
std::string emptiest_corner(const std::vector<Point>& outline, std::size_t lines) {
  const double width = 0.42, height = 0.03 + 0.065 * static_cast<double>(lines);
  std::string best;
  std::size_t least = outline.size() + 1;
  for (const bool top : {true, false})
    for (const bool right : {true, false}) {
      const auto covered = static_cast<std::size_t>(std::count_if(outline.begin(), outline.end(), [&](const Point& p) {
        return (right ? p.x > 1.0 - width : p.x < width) && (top ? p.y > 1.0 - height : p.y < height);
      }));
      if (covered >= least) continue;
      least = covered;
      best = std::string(right ? "right " : "left ") + (top ? "top" : "bottom");
    }
  return best;
}

/// Points along the curves, close enough for emptiest_corner, in shares of the axes.
std::vector<Point> sample_curves(const Plot& plot, const Axis& x, const Axis& y) {
  std::vector<Point> outline;
  for (const PlotSeries& series : plot.series) {
    const std::vector<Point> points = drawable_points(series, plot.log_x, plot.log_y);
    if (series.line == PlotLine::none)
      for (const Point& p : points) outline.push_back({x.share(p.x), y.share(p.y)});
    for (std::size_t i = 1; i < points.size() && series.line != PlotLine::none; ++i) {
      const Point a{x.share(points[i - 1].x), y.share(points[i - 1].y)}, b{x.share(points[i].x), y.share(points[i].y)};
      const int steps = 1 + static_cast<int>(std::hypot(b.x - a.x, b.y - a.y) / 0.02);
      for (int k = 0; k <= steps; ++k)
        outline.push_back({a.x + (b.x - a.x) * k / steps, a.y + (b.y - a.y) * k / steps});
    }
  }
  return outline;
}

}  // namespace

double logarithmic_slope(const PlotSeries& series) {
  const std::vector<Point> points = drawable_points(series, true, true);
  if (points.size() < 2) return std::numeric_limits<double>::quiet_NaN();
  double mean_x = 0.0, mean_y = 0.0, xx = 0.0, xy = 0.0;
  for (const Point& p : points) mean_x += std::log(p.x), mean_y += std::log(p.y);
  mean_x /= static_cast<double>(points.size()), mean_y /= static_cast<double>(points.size());
  for (const Point& p : points) {
    const double dx = std::log(p.x) - mean_x;
    xx += dx * dx, xy += dx * (std::log(p.y) - mean_y);
  }
  return xx > 0.0 ? xy / xx : std::numeric_limits<double>::quiet_NaN();
}

std::string gnuplot_script(const Plot& plot, const std::filesystem::path& svg) {
  Axis x{.logarithmic = plot.log_x}, y{.logarithmic = plot.log_y};
  std::string data, curves;
  std::vector<EndLabel> labels;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const PlotSeries& series = plot.series[i];
    const std::vector<Point> points = drawable_points(series, plot.log_x, plot.log_y);
    if (points.empty()) continue;
    const std::string block = "$curve" + std::to_string(i);
    data += block + " << END\n";
    for (const Point& p : points) {
      x.include(p.x), y.include(p.y);
      data += number(p.x, "%.17g") + " " + number(p.y, "%.17g") + "\n";
    }
    data += "END\n";
    if (series.line != PlotLine::none) labels.push_back({i, points.back().x, points.back().y, 0.0, 0.0});
    std::string title = series.label;
    if (plot.log_x && plot.log_y && series.line == PlotLine::joined_with_slope && points.size() > 1)
      title += ", slope " + number(std::abs(logarithmic_slope(series)), "%.2f");
    const std::string color = palette[i % palette.size()];
    const bool marked = points.size() <= 60;  // a curve of many points is a line; marks would hide it
    const std::string mark = "points pt " + std::to_string(point_types[i % point_types.size()]) + " ps 0.7";
    curves += (curves.empty() ? "plot " : ", \\\n     ") + block + " using 1:2 with " +
              (series.line == PlotLine::none    ? mark
               : series.line == PlotLine::steps ? "steps"
               : marked                         ? "lines" + mark
                                                : "lines") +
              " lw 2.2 lc rgb \"" + color + "\" title " + gnuplot_string(title);
    if (series.line == PlotLine::steps && marked)
      curves += ", \\\n     " + block + " using 1:2 with " + mark + " lw 2.2 lc rgb \"" + color + "\" notitle";
  }
  x.widen(0.04, 0.2), y.widen(0.06, 0.1);
  for (EndLabel& label : labels) label.shown_x = x.share(label.x), label.shown_y = y.share(label.y);
  spread(labels);
  std::vector<Point> outline = sample_curves(plot, x, y);
  for (const EndLabel& label : labels)
    for (const double along : {0.0, 0.1, 0.2}) outline.push_back({label.shown_x + along, label.shown_y});

  std::string script =
      "set terminal svg size 900,600 noenhanced font \"DejaVu Sans,Helvetica,sans-serif,15\" "
      "background rgb \"white\" linewidth 1\n";
  script += "set output " + gnuplot_string(svg.string()) + "\n" + data;
  script += "set title " + gnuplot_string(plot.title) + " font \",18\" offset 0,0.3\n";
  script +=
      "set xlabel " + gnuplot_string(plot.x_label) + "\nset ylabel " + gnuplot_string(plot.y_label) + " offset 0.5,0\n";
  if (plot.log_x) script += "set logscale x 10\n";
  if (plot.log_y) script += "set logscale y 10\n";
  script += "set xrange [" + number(x.low) + ":" + number(x.high) + "]\n";
  script += "set yrange [" + number(y.low) + ":" + number(y.high) + "]\n";
  script += x.ticks("x") + y.ticks("y");
  script += "set border 3 lc rgb \"#555555\"\nset tics nomirror out scale 0.6,0.3 textcolor rgb \"#333333\"\n";
  script += "set grid xtics ytics lt 1 lw 0.7 lc rgb \"#DDDDDD\"\n";
  script += "set key " + emptiest_corner(outline, plot.series.size()) +
            " Left reverse samplen 2 spacing 1.25 opaque fillcolor rgb \"white\"\n";
  script += "set rmargin 6\n";
  for (const EndLabel& label : labels)
    script += "set label " + gnuplot_string(plot.series[label.series].label) + " at graph " + number(label.shown_x) +
              ",graph " + number(label.shown_y) + " left offset 1,0 front textcolor rgb \"" +
              palette[label.series % palette.size()] + "\"\n";
  return script + curves + "\n";
}

PlotReport draw_plot(const Plot& plot, const std::filesystem::path& directory) {
  const std::filesystem::path file = directory / plot.file;
  const std::filesystem::path drawing = temporary_beside(file);
  const std::string script = gnuplot_script(plot, drawing);
  if (script.find("\nplot ") == std::string::npos) return {false, plot.file + ": there is no point to draw"};
  const std::filesystem::path program = temporary_beside(directory / (plot.file + ".gp"));
  try {
    write_file_atomically(program, script);
  } catch (const std::exception& error) {
    return {false, error.what()};
  }

  std::string name = "gnuplot", argument = program.string();
  char* arguments[] = {name.data(), argument.data(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  // Standard output may be carrying the result document; gnuplot must not add to it.
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int error = posix_spawnp(&child, "gnuplot", &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  int status = -1;
  if (error == 0)
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;

  std::error_code ignored, failed;
  std::filesystem::remove(program, ignored);
  if (error == ENOENT) return {false, plot.file + " was not drawn: gnuplot is not installed"};
  if (error != 0) return {false, plot.file + " was not drawn: gnuplot: " + std::strerror(error)};
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && std::filesystem::exists(drawing, ignored)) {
    std::filesystem::rename(drawing, file, failed);
    if (!failed) return {true, {}};
  }
  std::filesystem::remove(drawing, ignored);
  return {false, plot.file + " was not drawn: gnuplot failed"};
}

}  // namespace finegauge
