#include "benchmarks/profile/trace_events.hpp"

namespace finegauge {
namespace {

constexpr int process_id = 1, thread_id = 1;

Json metadata(const char* kind, const std::string& name) {
  return {{"name", kind}, {"ph", "M"}, {"pid", process_id}, {"tid", thread_id}, {"args", {{"name", name}}}};
}

}  // namespace

TraceEvents::TraceEvents(const std::string& process) {
  events_.push_back(metadata("process_name", process));
  events_.push_back(metadata("thread_name", "frames and their stages"));
}

double TraceEvents::microseconds(std::int64_t at) {
  if (!started_) start_ = at;
  started_ = true;
  return 1e-3 * static_cast<double>(at - start_);
}

void TraceEvents::add_span(const std::string& name, std::int64_t begin, std::int64_t end, Json arguments) {
  Json event = {{"name", name}, {"ph", "X"}, {"pid", process_id}, {"tid", thread_id}};
  event["ts"] = microseconds(begin);
  event["dur"] = 1e-3 * static_cast<double>(end - begin);
  if (!arguments.empty()) event["args"] = std::move(arguments);
  events_.push_back(std::move(event));
}

void TraceEvents::add_counter(const std::string& name, std::int64_t at,
                              const std::vector<std::pair<std::string, double>>& values) {
  Json event = {{"name", name}, {"ph", "C"}, {"pid", process_id}, {"tid", thread_id}};
  event["ts"] = microseconds(at);
  event["args"] = Json::object();
  for (const auto& [series, value] : values) event["args"][series] = value;
  events_.push_back(std::move(event));
}

std::string TraceEvents::text(const Json& notes) const {
  const Json document = {{"traceEvents", events_}, {"displayTimeUnit", "ms"}, {"otherData", notes}};
  return document.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace finegauge
