/// \file
/// One self-contained HTML page per result: the answer in a sentence, the figures, the details, where it came from.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "simgap/report/html/charts.h"
#include "simgap/report/table.h"

namespace simgap {

/// A paragraph that stands out.
struct PageText {
  std::string text;
};

/// A view into three dimensions that a reader can turn: an arm over its poses, or markers over time.
struct PageScene {
  std::string caption;
  std::string note;
  Json scene;  ///< as templates/arm_view.js reads it
};

/// A picture; the page holds a copy.
struct PageImage {
  std::string caption;
  std::string png;  ///< the bytes of the file
};

using PageBlock = std::variant<PageText, Table, Chart, PageScene, PageImage>;

/// Whether a reader can use the result, why (not), and what to run next.
struct PageVerdict {
  enum class Level { kGood, kDoubtful, kBad };
  Level level = Level::kGood;
  std::string words;    ///< "good", "worse than the start", "13 of 15 poses valid"
  std::string cause;    ///< in a sentence
  std::string command;  ///< to copy into a shell; may be empty
};

struct PageSection {
  std::string heading;  ///< empty for the figure right below the answer
  std::vector<PageBlock> blocks;
  bool folded = false;  ///< shown when a reader opens it; needs a heading
};

struct Page {
  std::string title;
  std::string answer;              ///< the result in one sentence
  std::vector<std::string> notes;  ///< what a reader must know before believing the answer
  std::vector<PageSection> sections = {};
  std::vector<std::pair<std::string, std::string>> provenance = {};
  std::optional<PageVerdict> verdict = {};

  /// Adds a block to the last section; to a first one without a heading when there is none.
  void add(PageBlock block) {
    if (sections.empty()) sections.emplace_back();
    sections.back().blocks.push_back(std::move(block));
  }
  void addSection(std::string heading, bool folded = false) { sections.push_back({std::move(heading), {}, folded}); }
};

/// The HTML text; opens from disk, needs no network.
std::string renderPage(const Page& page);

}  // namespace simgap
