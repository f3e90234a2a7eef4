#include "simgap/report/page.h"

#include <fmt/format.h>

#include <kainjow/mustache.hpp>

#include "pose_tables.h"
#include "simgap/report/assets.h"

namespace simgap {
namespace {

namespace mustache = kainjow::mustache;

// Okabe & Ito (2008): blue, vermilion, green, orange, purple, sky blue.
constexpr const char* kColours[] = {"#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9"};

constexpr const char* kTable =
    R"({{#folded}}<details><summary>{{caption}}</summary>{{/folded}}<div class="scroll"><table>
{{^folded}}<caption>{{caption}}</caption>{{/folded}}
<thead><tr>{{#header}}<th scope="col">{{cell}}</th>{{/header}}</tr></thead>
<tbody>{{#rows}}<tr>{{#cells}}<td>{{cell}}</td>{{/cells}}</tr>
{{/rows}}</tbody></table></div>{{#folded}}</details>{{/folded}}
)";

mustache::data cells(const std::vector<std::string>& texts) {
  mustache::data list{mustache::data::type::list};
  for (const std::string& text : texts) list << mustache::data{"cell", text};
  return list;
}

mustache::data tables(const std::vector<PageTable>& given) {
  mustache::data list{mustache::data::type::list};
  for (const PageTable& table : given) {
    mustache::data rows{mustache::data::type::list};
    for (const auto& row : table.rows) rows << mustache::data{"cells", cells(row)};
    mustache::data item;
    item.set("caption", table.caption);
    item.set("folded", table.folded);
    item.set("header", cells(table.header));
    item.set("rows", rows);
    list << item;
  }
  return list;
}

/// JSON inside a script element must neither end the element nor open a comment: "<" stands in its texts only.
std::string scriptSafe(const Json& json) {
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at))
    text.replace(at, 1, "\\u003c");
  return text;
}

Json points(const std::vector<double>& y) {
  Json values = Json::array();
  for (const double value : y) values.push_back(numberOrNull(value));
  return values;
}

}  // namespace

std::string renderPage(const Page& page) {
  Json configs = Json::array();
  mustache::data charts{mustache::data::type::list};
  for (const PageChart& chart : page.charts) {
    charts << mustache::data{"caption", chart.caption};
    configs.push_back(chart.config);
  }
  mustache::data provenance{mustache::data::type::list};
  for (const auto& [key, value] : page.provenance) {
    mustache::data item;
    item.set("key", key);
    item.set("value", value);
    provenance << item;
  }
  mustache::data data;
  data.set("title", page.title);
  data.set("answer", page.answer);
  data.set("tables", tables(page.tables));
  data.set("details", tables(page.details));
  data.set("charts", charts);
  data.set("provenance", provenance);
  data.set("chart_js", std::string(assets::chart_js()));
  data.set("chart_configs", scriptSafe(configs));
  data.set("table", mustache::data{mustache::partial{[] { return std::string(kTable); }}});
  mustache::mustache page_template{std::string(assets::report_html())};
  return page_template.render(data);
}

Json lineChart(const std::vector<double>& x, const std::vector<Series>& series, const std::string& x_title,
               const std::string& y_title, bool logarithmic) {
  Json datasets = Json::array();
  for (std::size_t i = 0; i < series.size(); ++i) {
    const char* colour = kColours[i % std::size(kColours)];
    datasets.push_back({{"label", series[i].name},
                        {"data", points(series[i].y)},
                        {"borderColor", colour},
                        {"backgroundColor", colour},
                        {"borderWidth", 2},
                        {"pointRadius", 0}});
  }
  return {
      {"type", "line"},
      {"data", {{"labels", x}, {"datasets", datasets}}},
      {"options",
       {{"interaction", {{"mode", "index"}, {"intersect", false}}},
        {"scales",
         {{"x",
           {{"title", {{"display", true}, {"text", x_title}}}, {"ticks", {{"maxRotation", 0}, {"maxTicksLimit", 12}}}}},
          {"y",
           {{"type", logarithmic ? "logarithmic" : "linear"}, {"title", {{"display", true}, {"text", y_title}}}}}}}}}};
}

Json barChart(const std::vector<std::string>& labels, const std::vector<Series>& series, const std::string& y_title) {
  Json config = lineChart({}, series, "", y_title, false);
  config["type"] = "bar";
  config["data"]["labels"] = labels;
  config["options"]["scales"]["x"] = Json::object();
  return config;
}

}  // namespace simgap
