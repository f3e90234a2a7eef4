#include "simgap/report/html/page.h"

#include <openssl/evp.h>

#include <algorithm>
#include <kainjow/mustache.hpp>
#include <string_view>

#include "simgap/report/html/assets.h"

namespace simgap {
namespace {

namespace mustache = kainjow::mustache;

/// JSON inside a script element must neither end the element nor open a comment: "<" stands in its texts only.
std::string scriptSafe(const Json& json) {
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at))
    text.replace(at, 1, "\\u003c");
  return text;
}

mustache::data cells(const std::vector<std::string>& texts) {
  mustache::data list{mustache::data::type::list};
  for (const std::string& text : texts) list << mustache::data{"cell", text};
  return list;
}

/// Cells of a table's row, from `begin` on; the columns of words are set apart from those of numbers.
mustache::data cells(const std::vector<std::string>& row, std::size_t begin, const std::vector<bool>& words) {
  mustache::data list{mustache::data::type::list};
  for (std::size_t c = begin; c < row.size(); ++c) {
    mustache::data item;
    item.set("cell", row[c]);
    item.set("words", c < words.size() && words[c]);
    list << item;
  }
  return list;
}

/// Per column: whether a cell reads as words, which stand to the left, where numbers stand to the right.
std::vector<bool> wordColumns(const Table& table) {
  std::vector<bool> words(table.header.size(), false);
  for (const auto& row : table.rows) {
    for (std::size_t c = 0; c < std::min(row.size(), words.size()); ++c) {
      if (!row[c].empty() && std::string_view("0123456789+-./").find(row[c].front()) == std::string_view::npos) {
        words[c] = true;
      }
    }
  }
  return words;
}

std::string base64(const std::string& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  const int length =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                      reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  text.resize(length);
  return text;
}

/// Turns blocks into what the template shows; the descriptions of charts and scenes are collected for report.js.
class BlockRenderer {
 public:
  mustache::data operator()(const PageText& text) { return block("text", mustache::data{text.text}); }

  mustache::data operator()(const Table& table) {
    const std::vector<bool> words = wordColumns(table);
    mustache::data rows{mustache::data::type::list};
    for (const auto& row : table.rows) {
      mustache::data item;
      item.set("name", row.empty() ? "" : row.front());
      item.set("cells", cells(row, 1, words));
      rows << item;
    }
    mustache::data item;
    item.set("caption", table.caption);
    item.set("folded", table.folded);
    item.set("header", cells(table.header, 0, words));
    item.set("rows", rows);
    return block("table", item);
  }

  mustache::data operator()(const Chart& chart) {
    mustache::data item = drawn(chart.caption, chart.note, chart.spec, charts);
    item.set("wide", chart.wide);
    return block("chart", item);
  }

  mustache::data operator()(const PageScene& scene) {
    return block("scene", drawn(scene.caption, scene.note, scene.scene, scenes));
  }

  mustache::data operator()(const PageImage& image) {
    mustache::data item;
    item.set("caption", image.caption);
    item.set("base64", base64(image.png));
    return block("image", item);
  }

  Json charts = Json::array(), scenes = Json::array();

 private:
  /// What report.js draws: its description joins the others, its place in the page knows which one it is.
  static mustache::data drawn(const std::string& caption, const std::string& note, const Json& spec, Json& all) {
    mustache::data item;
    item.set("caption", caption);
    if (!note.empty()) item.set("note", note);
    item.set("index", std::to_string(all.size()));
    all.push_back(spec);
    return item;
  }

  static mustache::data block(const char* kind, const mustache::data& item) {
    mustache::data block;
    block.set(kind, item);
    return block;
  }
};

/// Of PageVerdict::Level, in its order, as report.css knows them.
constexpr const char* kLevels[] = {"good", "doubtful", "bad"};

mustache::data verdictOf(const PageVerdict& verdict) {
  mustache::data item;
  item.set("level", kLevels[static_cast<int>(verdict.level)]);
  item.set("words", verdict.words);
  item.set("cause", verdict.cause);
  if (!verdict.command.empty()) item.set("command", mustache::data{"text", verdict.command});
  return item;
}

mustache::data provenanceOf(const Page& page) {
  mustache::data list{mustache::data::type::list};
  for (const auto& [key, value] : page.provenance) {
    mustache::data item;
    item.set("key", key);
    item.set("value", value);
    list << item;
  }
  return list;
}

}  // namespace

std::string renderPage(const Page& page) {
  BlockRenderer renderer;
  mustache::data sections{mustache::data::type::list};
  for (const PageSection& section : page.sections) {
    mustache::data blocks{mustache::data::type::list};
    for (const PageBlock& block : section.blocks) blocks << std::visit(renderer, block);
    mustache::data item;
    item.set("heading", section.heading);
    item.set("folded", section.folded);
    item.set("headed", !section.heading.empty());
    item.set("blocks", blocks);
    sections << item;
  }
  mustache::data data;
  data.set("title", page.title);
  data.set("answer", page.answer);
  if (page.verdict) data.set("verdict", verdictOf(*page.verdict));
  data.set("notes", cells(page.notes));
  data.set("noted", !page.notes.empty());
  data.set("sections", sections);
  data.set("provenance", provenanceOf(page));
  data.set("css", std::string(assets::report_css()));
  data.set("chart_js", std::string(assets::chart_js()));
  data.set("report_js", std::string(assets::report_js()));
  data.set("data", scriptSafe({{"charts", renderer.charts}, {"scenes", renderer.scenes}}));
  if (!renderer.scenes.empty()) {  // three.js is two thirds of a page
    mustache::data libraries;
    libraries.set("three_js", std::string(assets::three_js()));
    libraries.set("orbit_controls_js", std::string(assets::orbit_controls_js()));
    libraries.set("arm_view_js", std::string(assets::arm_view_js()));
    data.set("three_dimensions", libraries);
  }
  mustache::mustache page_template{std::string(assets::report_html())};
  return page_template.render(data);
}

}  // namespace simgap
