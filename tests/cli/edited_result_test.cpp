// `report` on results that somebody edited, or that were cut: an error that names what is wrong, or a page; never a
// crash.
#include "cli/cli_fixture.h"
#include "simgap/core/error.h"
#include "simgap/report/html/result_page.h"

namespace simgap::test {
namespace {

namespace fs = std::filesystem;

/// Every value of a document, outermost first; of long lists the first two.
std::vector<Json::json_pointer> places(const Json& json, const Json::json_pointer& at = Json::json_pointer()) {
  std::vector<Json::json_pointer> all{at};
  const auto append = [&](const Json& child, const Json::json_pointer& where) {
    const auto below = places(child, where);
    all.insert(all.end(), below.begin(), below.end());
  };
  if (json.is_object()) {
    for (const auto& [key, value] : json.items()) append(value, at / key);
  }
  for (std::size_t i = 0; json.is_array() && i < std::min<std::size_t>(json.size(), 2); ++i) append(json[i], at / i);
  return all;
}

const std::vector<Json> kStrangers = {nullptr, Json::array(),          Json::object(), "", "a word", -1, 1e308,
                                      true,    Json::array({nullptr}), Json{{"a", 1}}};

class EditedResultTest : public CliTest {
 protected:
  /// A page, or an Error with a sentence. \returns whether there was a page
  bool makes(const std::string& what) const {
    try {
      makePage(ResultFiles(path("out")));
      return true;
    } catch (const Error& error) {
      EXPECT_STRNE(error.what(), "") << what;
    } catch (const std::exception& error) {
      ADD_FAILURE() << what << ": " << error.what();
    }
    return false;
  }

  void editResult() const {
    const Json result = Json::parse(text("out/result.json"));
    std::size_t pages = 0, refusals = 0;
    for (const Json::json_pointer& place : places(result)) {
      if (place.empty()) continue;
      Json cut = result;
      Json& parent = cut[place.parent_pointer()];
      if (parent.is_object()) {
        parent.erase(place.back());
        put("out/result.json", cut.dump());
        (makes("without " + place.to_string()) ? pages : refusals) += 1;
      }
      for (const Json& stranger : kStrangers) {
        Json edited = result;
        edited[place] = stranger;
        put("out/result.json", edited.dump());
        (makes(place.to_string() + " = " + stranger.dump()) ? pages : refusals) += 1;
      }
    }
    put("out/result.json", result.dump());
    EXPECT_GT(pages, 0u);
    EXPECT_GT(refusals, 0u);
  }

  void editTables() const {
    for (const auto& entry : fs::directory_iterator(path("out"))) {
      if (entry.path().extension() != ".csv") continue;
      const std::string good = readText(entry.path()), name = "out/" + entry.path().filename().string();
      const std::string header = firstLines(good, 1);
      std::string nan = header;
      for (const char c : firstLines(good, 4).substr(header.size())) nan += c >= '0' && c <= '9' ? '0' : c;
      for (const std::string& edited :
           {std::string(), header, firstLines(good, 2), nan, header + std::string(countOf(header, ","), ',') + "\n",
            replaced(good, header, "a,b\n"), header.substr(header.find(',') + 1), good.substr(0, good.size() / 2)}) {
        put(name, edited);
        makes(name + " = " + firstLines(edited, 2));
      }
      fs::remove(path(name));
      makes("without " + name);
      put(name, good);
    }
    EXPECT_TRUE(makes("as it was"));
  }

  void edit() const {
    editResult();
    editTables();
  }
};

TEST_F(EditedResultTest, OfACalibration) {
  put("config.yaml", quickConfig(1));
  put("others.csv", posesOfSample(3, 3));
  succeed(calibrate("out", {"--validation", "others.csv"}));
  edit();
}

TEST_F(EditedResultTest, OfAValidation) {
  succeed({"validate", "arm.yaml", "--poses", "poses.csv", "-q", "-o", "out", "--max-mje", "90"});
  edit();
}

TEST_F(EditedResultTest, OfASpring) {
  succeed({"fit-spring", sourceFile("data/logs/shock-cord.csv.gz"), "-q", "-o", "out"});
  edit();
}

TEST_F(EditedResultTest, OfAFrictionFit) {
  succeed({"fit-friction", sourceFile("data/logs/none.csv.gz"), "-q", "-o", "out"});
  edit();
}

TEST_F(EditedResultTest, OfADiagnosis) {
  succeed({"diagnose", "spring", "--log", sourceFile("data/logs/shock-cord.csv.gz"), "-q", "-o", "out"});
  edit();
}

TEST_F(EditedResultTest, NestedTooDeepToBeShown) {
  succeed({"validate", "arm.yaml", "--poses", "poses.csv", "-q", "-o", "out"});
  put("out/result.json",
      "{\"format\": \"other\", \"a\": " + std::string(100'000, '[') + std::string(100'000, ']') + "}");
  const ProcessResult result = simgap({"report", "out"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, testing::HasSubstr("nested more than"));
}

}  // namespace
}  // namespace simgap::test
