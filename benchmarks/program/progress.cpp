#include "benchmarks/program/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace finegauge {

Progress::Progress(bool quiet)
    : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0), start_(std::chrono::steady_clock::now()) {}

Progress::~Progress() { clear(); }

void Progress::clear() const {
  if (line_open_) std::fputs("\r\033[K", stderr);
  line_open_ = false;
}

double Progress::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void Progress::update(double fraction, const std::string& doing) {
  if (quiet_) return;
  fraction = shown_ = std::max(shown_, std::clamp(fraction, 0.0, 1.0));
  const int percent = static_cast<int>(100.0 * fraction);
  if (!terminal_) {
    // What goes on for long is told again now and then.
    constexpr double often = 30.0;  // [s]
    if (doing == told_ && seconds() - told_at_ < often) return;
    told_ = doing;
    told_at_ = seconds();
    std::fprintf(stderr, "%3d %%  %s\n", percent, doing.c_str());
    return;
  }
  std::string left;
  // The first few percent say little about the rest.
  if (fraction > 0.02 && fraction < 1.0 && seconds() > 1.0)
    left = ", about " + duration_text(seconds() * (1.0 - fraction) / fraction) + " left";
  std::fprintf(stderr, "\r\033[K%3d %%  %s (%s%s)", percent, doing.c_str(), duration_text(seconds()).c_str(),
               left.c_str());
  std::fflush(stderr);
  line_open_ = true;
}

void Progress::note(const std::string& line) const {
  if (quiet_) return;
  clear();
  std::fprintf(stderr, "%s\n", line.c_str());
}

std::string duration_text(double seconds) {
  const long whole = std::lround(std::max(0.0, seconds));
  if (whole < 60) return std::to_string(whole) + " s";
  if (whole < 3600) return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
  return std::to_string(whole / 3600) + " h " + std::to_string(whole / 60 % 60) + " min";
}

}  // namespace finegauge
