#pragma once

#include <sstream>
#include <string>

namespace finegauge {

/// A number as a message shows it: at most so many significant digits, no zeros after the last of them.
inline std::string plain_number(double value, int digits = 12) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

}  // namespace finegauge
