#pragma once

#include <chrono>
#include <string>

namespace finegauge {

/// Tells on standard error how far the work is: one line that is rewritten, with the time left, on a terminal; plain
/// lines elsewhere, one for each thing that is done and further ones where it takes long; nothing when quiet. Standard
/// output is left alone.
class Progress {
 public:
  explicit Progress(bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// fraction: of the whole, 0 to 1. An estimate may take back what it promised; what is shown never falls.
  void update(double fraction, const std::string& doing);
  /// A line that stays.
  void note(const std::string& line) const;
  /// Removes the line that is rewritten, before other output.
  void clear() const;
  double seconds() const;  ///< since construction

 private:
  bool quiet_, terminal_;
  mutable bool line_open_ = false;
  double shown_ = 0.0;
  std::string told_;  ///< the last plain line, and when
  double told_at_ = 0.0;
  std::chrono::steady_clock::time_point start_;
};

/// "8 s", "3 min 20 s", "2 h 5 min".
std::string duration_text(double seconds);

}  // namespace finegauge
