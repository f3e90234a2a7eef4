// Pages are made from the files of a directory alone; nothing in them can break out of its place.
#include "simgap/report/html/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "report/result_folder.h"
#include "simgap/report/html/assets.h"

namespace simgap {
namespace {

using test::chartOf;
using test::chartsOf;
using test::knownCalibration;
using test::knownValidation;
using test::ResultFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(CalibratePage, AnswersFirstAndHoldsEveryFigure) {
  const Page page = ResultFolder(knownCalibration()).page();
  EXPECT_EQ(page.answer,
            "On poses the search never saw the gap went from - to 3.00° (shoulder), from - to 4.00° (elbow).");
  EXPECT_EQ(page.sections.front().heading, "") << "the figure stands right below the answer";
  const Chart mje = chartOf(page, "Mean joint error of the best model so far");
  EXPECT_EQ(mje.spec.at("series")[0].at("x"), Json({1.0, 2.0}));
  EXPECT_EQ(mje.spec.at("series")[1].at("x"), 0) << "that of the first";
  EXPECT_EQ(mje.spec.at("series")[1].at("y"), Json({3.0, 1.0}));
  EXPECT_EQ(mje.spec.at("y").at("log"), true);
  const Chart fitness = chartOf(page, "Fitness");
  EXPECT_EQ(fitness.spec.at("series")[2].at("y"), Json({0.75, 0.5}));
  EXPECT_EQ(chartOf(page, "Step sizes, relative to the initial ones").spec.at("series")[0].at("y"), Json({2.0, 1.0}));
  const Chart poses = chartOf(page, "Error of each calibration pose, worst first");
  EXPECT_EQ(poses.spec.at("labels"), Json({"low", "a,\"b\""}));
  EXPECT_EQ(poses.spec.at("series")[0].at("name"), "shoulder before");
  EXPECT_EQ(poses.spec.at("series")[0].at("y"), Json({20.0, 20.0}));
  EXPECT_TRUE(chartOf(page, "Error of each validation pose, worst first").spec.at("series")[0].at("y")[0].is_null());
}

TEST(CalibratePage, WithoutValidationItSaysWhatTheAnswerIsWorth) {
  CalibrationResult result = knownCalibration();
  result.sets.pop_back();
  EXPECT_THAT(ResultFolder(result).page().answer, HasSubstr("only poses it has not seen"));
}

TEST(CalibratePage, ShowsWhatThePosesTellOfTheParameters) {
  CalibrationResult result = knownCalibration();
  result.uncertainty = PoseUncertainty{};
  result.uncertainty->parameters = {{100.0, 20.0, Verdict::kIdentifiable}, {0.1, 0.05, Verdict::kNotIdentifiable}};
  result.uncertainty->singular_values = {30.0, 0.5};
  result.uncertainty->combinations = {{{0, 1}, true, "a and b: only their sum"}};
  result.uncertainty->distances = {1.0, 12.0};
  result.sets[1].predicted = PredictedError{{2 * kDegree, kDegree}, {kDegree, kDegree}, {3.5 * kDegree, 2 * kDegree}};
  result.predicted_unseen = *result.sets[1].predicted;
  const Page page = ResultFolder(result).page();
  const Json rows = chartOf(page, "Parameters moved most").spec.at("rows");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].at("name"), "muscles.biceps.stiffness");  // 900 -> 1 is -8.99 prior standard deviations
  EXPECT_EQ(rows[0].at("value"), -8.99);
  EXPECT_EQ(rows[0].at("lower"), -9.19);
  EXPECT_EQ(rows[0].at("group"), "identifiable");
  EXPECT_EQ(rows[0].at("marked"), true);  // at its lower bound
  EXPECT_EQ(rows[1].at("value"), 2.0);    // 0.1 -> 0.3 with prior sd 0.1
  EXPECT_THAT(page.notes, ElementsAre(HasSubstr("the elbow misses by 4.00° where at most 2.00° was to be expected"),
                                      HasSubstr("a,\"b\" (12.0 sd)")));
}

TEST(ValidatePage, NamesTheWorstPoseFirstAndTheCriteriaThatFail) {
  const Page page = ResultFolder(knownValidation()).page();
  EXPECT_THAT(page.answer, HasSubstr("On 2 of 3 poses the simulation misses the robot by 20.00° (shoulder)"));
  EXPECT_THAT(page.notes, ElementsAre(HasSubstr("mje_deg of elbow is -, which fails the limit of 5")));
  const Table* poses = nullptr;
  for (const PageBlock& block : page.sections.back().blocks) {
    if (const auto* table = std::get_if<Table>(&block)) poses = table;
  }
  ASSERT_NE(poses, nullptr);
  ASSERT_EQ(poses->rows.size(), 3u);
  EXPECT_THAT(poses->rows[0], ElementsAre("<far>", "-", "-", "acquisition error", ""));
  EXPECT_THAT(poses->rows[1], ElementsAre("low", "20.00", "10.00", "steady", ""));
}

/// A diagnosis by the contract, with one cause and a self-test.
Json knownDiagnosis() {
  return Json::parse(
      R"({"format": "simgap/diagnose/1", "verdict": "ambiguous", "sentence": "A muscle bends round a bone.",
    "causes": [{"effect": "muscle-wrap", "target": "biceps", "sentence": "It bends.", "gain_heldout_percent": 20,
                "gain_ci95": [15, null], "p_adjusted": 0.001, "ambiguous_with": ["cord-creep"],
                "parameters": [{"name": "radius", "unit": "m", "value": 0.05, "ci95": [0.04, 0.06]}],
                "absorbed_by": [{"parameter": "k_v", "shift_sd": -4.2}]}],
    "baseline": {"mse": 9, "mse_heldout": 16, "noise_floor": 4}, "extended": {"mse": 8, "mse_heldout": 9},
    "error_unit": "deg2", "explainable_percent": 50, "explained_percent": 40, "next_experiment": "Bend it more.",
    "self_test": {"hidden": ["none", "wrap"], "answers": ["nothing", "wrap"], "count": [[19, 1], [2, 18]],
                  "false_alarm_rate": 0.05, "power": 0.9}})");
}

TEST(DiagnosePage, ShowsTheGapTheCausesTheEvidenceAndTheSelfTest) {
  const ResultFolder folder(knownDiagnosis());
  folder.directory().write("evidence.csv",
                           std::string_view("against,center,before,before_ci95,after,after_ci95,rows,unit\n"
                                            "load,1,0.5,0.1,0.05,0.2,7,Nm\n"));
  folder.directory().write("hypotheses.csv", std::string_view("step,effect,target,gain_percent,gain_lower95_percent,"
                                                              "gain_upper95_percent,p_adjusted,outcome\n"
                                                              "1,inertia,,nan,nan,nan,1,pruned\n"
                                                              "1,cord-creep,,18,10,26,0.01,ambiguous\n"
                                                              "1,muscle-wrap,biceps,20,15,25,0.001,accepted\n"));
  const Page page = folder.page();
  EXPECT_EQ(page.answer, "A muscle bends round a bone.");
  EXPECT_THAT(page.notes, ElementsAre("muscle-wrap of biceps cannot be told apart here from cord-creep."));
  const Json gap = chartOf(page, "The gap on data never used").spec;
  EXPECT_EQ(gap.at("series")[0].at("y"), Json({2.0, 4.0, 3.0})) << "roots of the squared errors";
  EXPECT_EQ(gap.at("y").at("title"), "RMS error [deg]");
  const Json gain = chartOf(page, "What each cause saves on data never used").spec.at("rows")[0];
  EXPECT_EQ(gain.at("lower"), 15.0);
  EXPECT_TRUE(gain.at("upper").is_null());
  const Json signature = chartOf(page, "Against load").spec;
  EXPECT_EQ(signature.at("series")[1].at("half"), Json({0.2}));
  EXPECT_EQ(signature.at("x").at("title"), "load [N m]");
  EXPECT_EQ(std::get<Chart>(page.sections[0].blocks[0]).caption, "Against load") << "the signature comes first";
  const Json rivals = chartOf(page, "Rivals of the first step, best first").spec.at("rows");
  ASSERT_EQ(rivals.size(), 2u) << "what was not judged has no place among them";
  EXPECT_EQ(rivals[0].at("name"), "muscle-wrap of biceps");
  EXPECT_EQ(rivals[1].at("group"), "ambiguous");
  const Json matrix = chartOf(page, "Self-test: what was hidden, and what was named").spec;
  EXPECT_EQ(matrix.at("row_names"), Json({"wrap", "none"})) << "from below";
  EXPECT_EQ(matrix.at("value"), Json({2.0, 18.0, 19.0, 1.0}));
  EXPECT_THAT(renderPage(page), HasSubstr("<p class=\"text\">Bend it more.</p>"));
}

TEST(Page, IsSelfContainedAndNamesWhereItCameFrom) {
  const std::string html = renderPage(ResultFolder(knownCalibration()).page());
  EXPECT_THAT(html, HasSubstr(assets::chart_js().substr(0, 200)));
  EXPECT_THAT(html, HasSubstr("On poses the search never saw the gap went from - to 3.00°"));
  EXPECT_THAT(html, HasSubstr("simgap command &lt;arm&gt; &amp; more"));
  EXPECT_THAT(html, HasSubstr(sha256("content")));
  for (const char* tag : {"{{#", "{{/", "{{{data", "{{cell"}) EXPECT_THAT(html, Not(HasSubstr(tag)));
  for (const char* outside : {"src=\"http", "href=\"http", "@import", "url("})
    EXPECT_THAT(html, Not(HasSubstr(outside)));
  EXPECT_EQ(test::countOf(html, "<canvas"), chartsOf(ResultFolder(knownCalibration()).page()).size());
}

TEST(Page, IsTheSameWheneverItIsMade) {
  const ResultFolder folder(knownCalibration());
  writeReport(folder.directory());
  const std::string first = test::readText(folder.directory().file("report.html"));
  writeReport(folder.directory());
  EXPECT_EQ(test::readText(folder.directory().file("report.html")), first);
}

TEST(Page, NamesCannotBreakOut) {
  const std::vector<std::string> names{"</script><b>x", "<!--<script>", "<img src=x onerror=alert(1)>",
                                       "a\"b'c&d",      "{{title}}",    "{{{chart_js}}}",
                                       "\xFF latin",    "line\nbreak",  "\xE2\x80\xA8"};
  const ValidationResult plain = knownValidation();
  const std::string harmless = renderPage(ResultFolder(plain).page());
  for (const std::string& name : names) {
    ValidationResult result = plain;
    result.set.poses[0].name = name;
    const std::string html = renderPage(ResultFolder(result).page());
    SCOPED_TRACE(name);
    for (const char* tag : {"<script", "</script", "<!--", "<b>", "<img", "<canvas"}) {
      EXPECT_EQ(test::countOf(html, tag), test::countOf(harmless, tag)) << tag;
    }
    EXPECT_LT(html.size(), harmless.size() + 500);
  }
}

TEST(Page, OfFifteenPosesWithoutTheArmIsAtMost400KB) {
  CalibrationResult result = knownCalibration();
  while (result.state.history.size() < 250) result.state.history.push_back(result.state.history[1]);
  result.parameters.resize(99, result.parameters[0]);
  result.state.strategy.best.y.resize(99, 0.123456789);
  for (SetResult& set : result.sets) {
    for (Assessment* judged : {&set.initial, &set.final}) {
      judged->outcomes.resize(15, judged->outcomes[0]);
      judged->errors.resize(15, judged->errors[0]);
    }
    set.set.poses.resize(15, set.set.poses[0]);
  }
  EXPECT_LE(renderPage(ResultFolder(result).page()).size(), 400'000u);
}

TEST(Page, OfAnUnknownCommandShowsWhatItFound) {
  const Json result = {
      {"format", "simgap/measure-moon/1"}, {"distance_km", 384400}, {"craters", {{{"name", "Tycho"}, {"age", 1}}}}};
  const Page page = ResultFolder(result).page();
  EXPECT_EQ(page.title, "simgap measure-moon");
  const auto* figures = std::get_if<Table>(&page.sections.at(0).blocks.at(0));
  ASSERT_NE(figures, nullptr);
  EXPECT_THAT(figures->rows, ElementsAre(ElementsAre("distance_km", "384400")));
  EXPECT_THAT(renderPage(page), HasSubstr("<th scope=\"row\">Tycho</th>"));
}

TEST(Page, OfDamagedFilesIsRefusedWithTheirName) {
  const ResultFolder lacking(Json{{"format", "simgap/calibrate/1"}});
  EXPECT_THAT(test::errorOf([&] { lacking.page(); }),
              ::testing::AllOf(HasSubstr("3: "), HasSubstr("result.json: is no complete result")));
  const ResultFolder broken(knownCalibration());
  broken.directory().write("result.json", std::string_view("{"));
  EXPECT_THAT(test::errorOf([&] { broken.page(); }), HasSubstr("result.json: found no JSON"));
  const ResultFolder words(knownCalibration());
  words.directory().write("history.csv", test::replaced(historyCsv(knownCalibration()), "0.25", "much"));
  EXPECT_THAT(test::errorOf([&] { words.page(); }), HasSubstr("history.csv:3: "));
  std::filesystem::remove(words.directory().file("result.json"));
  EXPECT_THAT(test::errorOf([&] { words.page(); }),
              ::testing::AllOf(HasSubstr("2: "), HasSubstr("found no result.json")));
}

TEST(Page, SaysWhenARunHasFailed) {
  const ResultFolder folder(knownValidation());
  RunRecord({"simgap"}, 1, 1).write(folder.directory(), "failed: one pose is invalid");
  EXPECT_EQ(folder.page().verdict->level, PageVerdict::Level::kBad);
  EXPECT_EQ(folder.page().verdict->cause, "The run ended as: failed: one pose is invalid.");
}

TEST(Thinning, KeepsEveryPeakTheOrderAndTheGaps) {
  Series line{"line", {}, {}};
  for (int i = 0; i < 100'000; ++i) {
    line.x.push_back(i);
    line.y.push_back(std::sin(0.001 * i));
  }
  line.y[12'345] = 7.0;
  line.y[54'321] = -7.0;
  line.y[77'777] = std::nan("");
  const Series thin = thinned(line);
  EXPECT_LE(thin.y.size(), kMostPoints + 1);
  EXPECT_GT(thin.y.size(), kMostPoints / 2);
  EXPECT_TRUE(std::ranges::is_sorted(thin.x));
  const auto at = [&](double x) {
    const auto found = std::ranges::find(thin.x, x);
    return found == thin.x.end() ? 0.0 : thin.y[found - thin.x.begin()];
  };
  EXPECT_EQ(at(12'345), 7.0);
  EXPECT_EQ(at(54'321), -7.0);
  EXPECT_TRUE(std::isnan(at(77'777)));
  EXPECT_EQ(thinned(thin, 5000).x, thin.x) << "what is short enough stays";
}

TEST(Charts, NumbersAreShortAndUnknownOnesNull) {
  const Chart chart = lineChart("c", {"x"}, {"y"}, {{"s", {1.0 / 3.0, 2.0}, {std::nan(""), 1e300 * 1e300}}});
  EXPECT_EQ(chart.spec.at("series")[0].at("x")[0].dump(), "0.3333333");
  EXPECT_TRUE(chart.spec.at("series")[0].at("y")[0].is_null());
  EXPECT_TRUE(chart.spec.at("series")[0].at("y")[1].is_null());
}

}  // namespace
}  // namespace simgap
