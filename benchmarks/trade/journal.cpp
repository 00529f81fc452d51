#include "benchmarks/trade/journal.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>

#include "benchmarks/program/atomic_file.hpp"
#include "benchmarks/program/command.hpp"

namespace finegauge {
namespace {

/// What differs between two headers, by its first key.
std::string difference(const Json& here, const Json& there) {
  for (const auto& [key, value] : here.items())
    if (!there.is_object() || !there.contains(key) || there.at(key) != value) return key;
  return "keys";
}

}  // namespace

Journal::Journal(std::filesystem::path file, const Json& header, bool resume) : file_(std::move(file)) {
  std::ifstream in(file_, std::ios::binary);
  std::string line, whole;
  bool begun = false;
  while (std::getline(in, line)) {
    if (in.eof()) break;  // no end of line: cut off
    const Json json = Json::parse(line, nullptr, false);
    if (json.is_discarded()) break;
    if (!begun) {
      if (!resume)
        throw UsageError(file_.string() +
                         " is of a sweep that was begun: --resume goes on with it, another --out leaves it");
      if (json != header)
        throw UsageError("--resume: " + file_.string() + " is of another sweep, by its " + difference(header, json));
      begun = true;
    } else {
      lines_.push_back(json);
    }
    whole += line + "\n";
  }
  in.close();
  // What is whole, once more, so that the next line starts at the beginning of one.
  write_file_atomically(file_, begun ? whole : header.dump() + "\n");
}

void Journal::append(const Json& line) {
  write(line);
  lines_.push_back(line);
}

void Journal::write(const Json& line) {
  const std::string text = line.dump() + "\n";
  const auto fail = [&] { throw std::runtime_error(file_.string() + ": " + std::strerror(errno)); };
  const int out = ::open(file_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (out < 0) fail();
  const bool written = ::write(out, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && ::fsync(out) == 0;
  if (!written) fail();
  ::close(out);
}

}  // namespace finegauge
