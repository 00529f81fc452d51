#include "benchmarks/report/page.hpp"

#include <algorithm>

#include "benchmarks/program/build_info.hpp"
#include "benchmarks/report/html.hpp"
#include "benchmarks/report/page_parts.hpp"
#include "benchmarks/report/section.hpp"

namespace finegauge {
namespace {

struct Section {
  const char* id;
  const char* title;
  const char* about;
  std::string (*write)(PageState&);
};

constexpr Section sections[] = {
    {"summary", "Summary", "", &summary_section},
    {"accuracy", "Accuracy", "How wrong the computed is: against the paper’s numbers, and over degrees of freedom.",
     &accuracy_section},
    {"certificate", "Certificate",
     "The claims that the program’s numbers rest on, each with two-sided bounds and their reason.",
     &certificate_section},
    {"scenes", "Scenes", "What ran, frame by frame: forces, sizes, errors and times.", &scenes_section},
    {"trade", "Trade", "What accuracy costs: every setting tried, and the cheapest ones.", &trade_section},
    {"audit", "Audit", "What the scene needs of the model, and what it could spare.", &audit_section},
    {"profile", "Profile", "Where a frame’s time goes, and what hanging nodes cost.", &profile_section},
    {"atlas", "Atlas", "How far from usual values the simulation stays sound, an axis at a time.", &atlas_section},
    {"budgets", "Budgets", "What must not get worse, and how it has changed.", &budgets_section},
    {"environments", "Environments", "The builds and machines that the numbers are of, and their inputs.",
     &environments_section}};

}  // namespace

std::string report_page(const std::vector<ReportDocument>& documents) {
  PageState page{documents};
  std::string contents, body;
  for (const Section& section : sections) {
    const std::string inner = section.write(page);
    if (inner.empty()) continue;
    contents += "<a href=\"#" + std::string(section.id) + "\">" + section.title + "</a>\n";
    body += "<section id=\"" + std::string(section.id) + "\">\n<h2>" + section.title + "</h2>\n";
    if (*section.about) body += std::string("<p class=\"lead\">") + section.about + "</p>\n";
    body += inner + "</section>\n";
  }
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<meta name=\"color-scheme\" content=\"light dark\">\n"
         // Whatever a document or picture has smuggled in, the browser fetches nothing for it.
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; "
         "script-src 'unsafe-inline'; img-src data:\">\n"
         "<link rel=\"icon\" href=\"data:,\">\n<title>Finegauge report</title>\n<style>\n" +
         std::string(page_style) + "</style>\n</head>\n<body>\n<header><h1>Finegauge report</h1></header>\n<nav>" +
         contents + "</nav>\n<main>\n" + body + "</main>\n<footer>finegauge " + html_escaped(build_info::version) +
         " (" + html_escaped(build_info::commit) + ")</footer>\n<div id=\"tip\" hidden></div>\n<script>\n" +
         page_script + "</script>\n</body>\n</html>\n";
}

}  // namespace finegauge
