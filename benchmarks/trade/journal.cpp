#include "benchmarks/trade/journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "benchmarks/program/command.hpp"

namespace finegauge {
namespace {

/// What differs between two headers, by its first key.
std::string difference(const Json& here, const Json& there) {
  for (const auto& [key, value] : here.items())
    if (!there.is_object() || !there.contains(key) || there.at(key) != value) return key;
  return "keys";
}

/// Whatever bytes names and messages have.
std::string line_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"; }

/// A sweep that was killed keeps its lock until the run that it waited for is gone too, a moment later.
void require_alone(int open, const std::filesystem::path& file) {
  constexpr int tries = 20;
  constexpr useconds_t between = 50'000;  // [microseconds]
  for (int i = 0; i < tries; ++i) {
    if (i > 0) ::usleep(between);
    if (::flock(open, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;  // not every file system has locks
  }
  ::close(open);
  throw UsageError(file.string() + " is of a sweep that runs at this moment");
}

}  // namespace

std::vector<Json> journal_lines(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<Json> lines;
  for (std::string line; std::getline(in, line) && !in.eof();) {
    lines.push_back(Json::parse(line, nullptr, false));
    if (lines.back().is_discarded())
      throw UsageError(file.string() + ":" + std::to_string(lines.size()) + ": found no line of a journal");
  }
  if (lines.empty()) throw UsageError(file.string() + ": found no journal of a sweep");
  return lines;
}

Journal::Journal(std::filesystem::path file, const Json& header, bool resume)
    : file_(std::move(file)), header_(Json::parse(line_of(header))) {
  std::ifstream in(file_, std::ios::binary);
  if (!in) return;
  const int open = ::open(file_.c_str(), O_RDWR | O_APPEND | O_CLOEXEC);
  if (open < 0) fail();
  require_alone(open, file_);
  try {
    whole_ = read({std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()}, resume);
  } catch (...) {
    ::close(open);
    throw;
  }
  open_ = open;
}

Journal::~Journal() {
  if (open_ >= 0) ::close(open_);
}

std::size_t Journal::read(const std::string& content, bool resume) {
  std::size_t whole = 0;
  int number = 0;
  for (std::size_t end; (end = content.find('\n', whole)) != std::string::npos; whole = end + 1) {
    ++number;
    const Json json = Json::parse(content.substr(whole, end - whole), nullptr, false);
    if (json.is_discarded())
      throw UsageError(file_.string() + ":" + std::to_string(number) + ": found no line of a journal; another --out");
    if (number > 1) {
      lines_.push_back(json);
      continue;
    }
    if (!resume)
      throw UsageError(file_.string() +
                       " is of a sweep that was begun: --resume goes on with it, another --out leaves it");
    if (json != header_)
      throw UsageError("--resume: " + file_.string() + " is of another sweep, by its " + difference(header_, json));
  }
  if (number == 0 && line_of(header_).rfind(content, 0) != 0)  // but a header that was cut off
    throw UsageError(file_.string() + ":1: found no line of a journal; another --out");
  return whole;
}

void Journal::append(const Json& line) {
  begin();
  write(line_of(line));
  lines_.push_back(line);
}

/// Before the first line: makes the file, or takes away what was cut off.
void Journal::begin() {
  if (begun_) return;
  if (open_ < 0) {
    std::error_code error;
    if (file_.has_parent_path()) std::filesystem::create_directories(file_.parent_path(), error);
    open_ = ::open(file_.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_EXCL | O_CLOEXEC, 0644);  // none but ours
    if (open_ < 0) fail();
    require_alone(open_, file_);
  }
  if (::ftruncate(open_, static_cast<off_t>(whole_)) != 0) fail();
  if (whole_ == 0) write(line_of(header_));
  begun_ = true;
}

void Journal::write(const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t wrote = ::write(open_, text.data() + done, text.size() - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) fail();
    done += static_cast<std::size_t>(wrote);
  }
  if (::fsync(open_) != 0 && errno != EINVAL) fail();  // EINVAL: no file of a disk
}

void Journal::fail() const { throw std::runtime_error(file_.string() + ": " + std::strerror(errno)); }

}  // namespace finegauge
