#include "simgap/core/run_directory.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fstream>
#include <iterator>
#include <thread>

#include "simgap/core/error.h"

namespace simgap {
namespace {

namespace fs = std::filesystem;

/// A folder of its own for every test.
class RunDirectoryTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "simgap-test-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  static void put(const fs::path& file, std::string_view text) { std::ofstream(file) << text; }
  static std::ptrdiff_t entries(const fs::path& folder) {
    return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
  }
  /// The sentence of the ConfigError that `action` must throw.
  template <class Action>
  static std::string errorOf(Action action) {
    try {
      action();
    } catch (const ConfigError& error) {
      return error.what();
    }
    ADD_FAILURE() << "no ConfigError was thrown";
    return {};
  }

  fs::path folder_;
};

TEST_F(RunDirectoryTest, WritesAndReadsBytes) {
  const std::string content("a\0b\r\n\xff", 6);
  writeFileAtomically(folder_ / "file", content);
  EXPECT_EQ(readFile(folder_ / "file"), content);
  writeFileAtomically(folder_ / "file", "");
  EXPECT_EQ(readFile(folder_ / "file"), "");
  const std::string large(3'000'001, 'x');
  writeFileAtomically(folder_ / "file", large);
  EXPECT_EQ(readFile(folder_ / "file"), large);
  EXPECT_EQ(entries(folder_), 1) << "a temporary file was left";
}

TEST_F(RunDirectoryTest, NewFilesHaveTheUsualPermissions) {
  const mode_t mask = umask(022);
  writeFileAtomically(folder_ / "file", "text");
  umask(mask);
  EXPECT_EQ(fs::status(folder_ / "file").permissions(), fs::perms{0644});
}

TEST_F(RunDirectoryTest, FailedWriteLeavesNothing) {
  const std::string sentence = errorOf([&] { writeFileAtomically(folder_ / "none" / "file", "text"); });
  EXPECT_NE(sentence.find("none/file: cannot be written: No such file"), std::string::npos) << sentence;

  fs::create_directory(folder_ / "taken");
  errorOf([&] { writeFileAtomically(folder_ / "taken", "text"); });  // a folder cannot be replaced by a file
  EXPECT_EQ(entries(folder_), 1) << "a temporary file was left";
}

TEST_F(RunDirectoryTest, ReadersNeverSeeAPartOfAFile) {
  const fs::path file = folder_ / "file";
  constexpr std::size_t kSize = 200'000;
  writeFileAtomically(file, std::string(kSize, 'a'));
  std::atomic<int> writing{2};
  const auto writer = [&](char letter) {
    for (int i = 0; i < 20; ++i) writeFileAtomically(file, std::string(kSize, letter));
    --writing;
  };
  std::thread first(writer, 'b'), second(writer, 'c');
  do {
    const std::string content = readFile(file);
    EXPECT_EQ(content.size(), kSize);
    EXPECT_EQ(content.find_first_not_of(content.front()), std::string::npos);
  } while (writing > 0);
  first.join();
  second.join();
  EXPECT_EQ(entries(folder_), 1) << "a temporary file was left";
}

TEST_F(RunDirectoryTest, UnreadableFileIsNamed) {
  const fs::path missing = folder_ / "missing.csv";
  EXPECT_EQ(errorOf([&] { readFile(missing); }), missing.string() + ": cannot be read: No such file or directory");
  EXPECT_EQ(errorOf([&] { readFile(folder_); }), folder_.string() + ": found a directory, expected a file");
  writeFileAtomically(folder_ / "model.yaml", "a: 1\n");
  EXPECT_EQ(errorOf([&] { readFile(folder_); }), folder_.string() +
                                                     ": found a directory, expected a file: the model of this run is " +
                                                     (folder_ / "model.yaml").string());
}

TEST_F(RunDirectoryTest, AFileThatIsTooLargeIsRefusedWhateverItsSize) {
  put(folder_ / "file", std::string(100, 'x'));
  EXPECT_EQ(readFile(folder_ / "file", 100).size(), 100u);
  EXPECT_NE(errorOf([&] { readFile(folder_ / "file", 99); }).find("found more than"), std::string::npos);
  EXPECT_NE(errorOf([&] { readFile("/dev/zero", 1 << 20); }).find("found more than 1 MiB"), std::string::npos);
}

TEST_F(RunDirectoryTest, ADirectoryIsForOneAtATime) {
  {
    const RunDirectory first = RunDirectory::create(folder_ / "run", false);
    first.write("run.json", "{}");
    for (const auto& other : {+[](const fs::path& run) { RunDirectory::create(run, true); },
                              +[](const fs::path& run) { RunDirectory::open(run); }}) {
      EXPECT_NE(errorOf([&] { other(folder_ / "run"); }).find("another simgap is working there"), std::string::npos);
    }
  }
  RunDirectory::open(folder_ / "run");
}

TEST_F(RunDirectoryTest, LeftoversOfAKilledProcessAreOurs) {
  fs::create_directory(folder_ / "run");
  put(folder_ / "run" / ".simgap-1-2.tmp", "half a file");
  RunDirectory::create(folder_ / "run", true);
  EXPECT_EQ(entries(folder_ / "run"), 0);
}

TEST_F(RunDirectoryTest, AnEndingSlashChangesNothing) {
  RunDirectory::create(folder_ / "run" / "", false);
  errorOf([&] { RunDirectory::create(folder_ / "run" / "", false); });
}

TEST_F(RunDirectoryTest, JsonIsReadNoDeeperThanItCanBeShown) {
  const auto sentence = [&](const std::string& text) {
    put(folder_ / "file.json", text);
    try {
      readJson(folder_ / "file.json");
    } catch (const DataError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_EQ(sentence(std::string(30, '[') + std::string(30, ']')), "no error");
  EXPECT_NE(sentence(std::string(100'000, '[')).find("nested more than 64 deep"), std::string::npos);
  EXPECT_NE(sentence("{\"a\":").find("found no JSON"), std::string::npos);
}

// FIPS 180-2, appendix B.
TEST(Sha256, GivesThePublishedAnswers) {
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

/// The text with every digit made 0: its form.
std::string formOf(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; }, '0');
  return text;
}

TEST(UtcTime, HasBothForms) {
  EXPECT_EQ(formOf(utcTime()), "0000-00-00T00:00:00Z");
  EXPECT_EQ(formOf(utcTime(true)), "00000000T000000Z");
}

TEST_F(RunDirectoryTest, MakesTheFoldersAbove) {
  const RunDirectory run = RunDirectory::create(folder_ / "a" / "b", false);
  run.write("text", "text");
  run.write("value.json", Json{{"z", 1}, {"a", std::nan("")}});
  EXPECT_EQ(readFile(run.file("text")), "text");
  EXPECT_EQ(readFile(run.file("value.json")), "{\n  \"z\": 1,\n  \"a\": null\n}\n");
}

TEST_F(RunDirectoryTest, RefusesWhatExists) {
  const std::string sentence = errorOf([&] { RunDirectory::create(folder_, false); });
  EXPECT_NE(sentence.find("--force"), std::string::npos) << sentence;
  put(folder_ / "file", "text");
  errorOf([&] { RunDirectory::create(folder_ / "file", true); });
  errorOf([&] { RunDirectory::create(folder_ / "file" / "below", true); });
  EXPECT_EQ(readFile(folder_ / "file"), "text");
}

TEST_F(RunDirectoryTest, ForceReplacesARunAndNothingElse) {
  const fs::path outside = folder_ / "outside", directory = folder_ / "run";
  fs::create_directory(outside);
  put(outside / "file", "text");
  fs::create_directory(directory);
  EXPECT_NO_THROW(RunDirectory::create(directory, true)) << "an empty folder";

  put(directory / "thesis.tex", "years of work");
  errorOf([&] { RunDirectory::create(directory, true); });
  EXPECT_EQ(readFile(directory / "thesis.tex"), "years of work");

  put(directory / "run.json", "{}");
  fs::create_directories(directory / "plots" / "deep");
  fs::create_directory_symlink(outside, directory / "link");
  RunDirectory::create(directory, true);
  EXPECT_EQ(entries(directory), 0);
  EXPECT_EQ(readFile(outside / "file"), "text") << "what a link points to is not ours";
}

TEST_F(RunDirectoryTest, OpensOnlyRuns) {
  errorOf([&] { RunDirectory::open(folder_); });
  errorOf([&] { RunDirectory::open(folder_ / "missing"); });
  put(folder_ / "run.json", "{}");
  EXPECT_EQ(RunDirectory::open(folder_).path(), folder_);
}

TEST_F(RunDirectoryTest, DefaultPathIsFree) {
  const fs::path before = fs::current_path();
  fs::current_path(folder_);
  std::vector<std::string> names;
  for (int i = 0; i < 3; ++i) {
    names.push_back(RunDirectory::defaultPath("calibrate").string());
    RunDirectory::create(names.back(), false);
  }
  fs::current_path(before);
  EXPECT_EQ(formOf(names[0]), "runs/calibrate-00000000T000000Z");
  for (const std::string& name : names) EXPECT_TRUE(formOf(name).starts_with(formOf(names[0]))) << name;
}

TEST_F(RunDirectoryTest, RunRecordHoldsWhatFormatsPromise) {
  const RunDirectory run = RunDirectory::create(folder_ / "run", false);
  RunRecord record({"simgap", "calibrate", "odd \xff byte"}, 18446744073709551615U, 2);
  record.addInput("poses", "poses.csv", "abc");
  record.write(run, "running");
  EXPECT_EQ(Json::parse(readFile(run.file("run.json"))).at("status"), "running");
  record.write(run, "failed: no valid individual");

  const Json json = Json::parse(readFile(run.file("run.json")));
  EXPECT_EQ(json.at("format"), "simgap/run/1");
  EXPECT_FALSE(json.at("version").get<std::string>().empty());
  EXPECT_FALSE(json.at("git_hash").get<std::string>().empty());
  EXPECT_EQ(json.at("argv"), Json({"simgap", "calibrate", "odd \xef\xbf\xbd byte"}));
  EXPECT_EQ(json.at("seed"), 18446744073709551615U);
  EXPECT_EQ(json.at("threads"), 2);
  EXPECT_FALSE(json.at("machine").at("cpu").get<std::string>().empty());
  EXPECT_GE(json.at("machine").at("cores"), 1);
  EXPECT_TRUE(json.at("machine").at("os").get<std::string>().starts_with("Linux "));
  EXPECT_EQ(json.at("start").get<std::string>().size(), 20);
  EXPECT_GE(json.at("duration_s"), 0.0);
  EXPECT_EQ(json.at("status"), "failed: no valid individual");
  EXPECT_EQ(json.at("inputs").at(0).at("role"), "poses");
  EXPECT_EQ(json.at("inputs").at(0).at("file"), "poses.csv");
  EXPECT_EQ(json.at("inputs").at(0).at("sha256"), sha256("abc"));
  EXPECT_EQ(json.begin().key(), "format") << "the order of writing is kept";
}

}  // namespace
}  // namespace simgap
