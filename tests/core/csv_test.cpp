#include "simgap/core/csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <random>

#include "core/csv_cells.h"
#include "simgap/core/error.h"
#include "support/files.h"

namespace simgap {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

CsvTable parseCsv(std::string_view text, const CsvOptions& options = {}) {
  return CsvTable::parse(std::string(text), "log.csv", options);
}

/// The sentence of the DataError that `read` throws.
std::string csvSentence(const std::function<void()>& read) {
  try {
    read();
  } catch (const DataError& error) {
    return error.what();
  }
  return "no error";
}

std::string parseSentence(std::string_view text) {
  return csvSentence([&] { parseCsv(text); });
}

std::string quantitySentence(std::string_view text, std::string_view stem, std::string_view unit) {
  return csvSentence([&] { parseCsv(text).quantity(stem, unit); });
}

/// A file that is gone at the end of the test.
class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& content)
      : path_(std::filesystem::temp_directory_path() / (std::to_string(getpid()) + "-" + name)) {
    std::ofstream(path_, std::ios::binary) << content;
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

TEST(Csv, ReadsNumbersAndTextsByColumn) {
  const CsvTable table = parseCsv("pose,elbow_rad,note\np0,1.5,good\np1,-2e-3,\n");
  EXPECT_EQ(table.rows(), 2u);
  EXPECT_THAT(table.columns(), ElementsAre("pose", "elbow_rad", "note"));
  EXPECT_THAT(table.quantity("elbow", "rad"), ElementsAre(1.5, -2e-3));
  EXPECT_THAT(table.text("pose"), ElementsAre("p0", "p1"));
  EXPECT_THAT(table.text("note"), ElementsAre("good", ""));
  EXPECT_EQ(table.lineOf(1), 3u);
  EXPECT_TRUE(table.has("note"));
  EXPECT_FALSE(table.has("elbow"));
  EXPECT_EQ(table.name(), "log.csv");
}

TEST(Csv, GivesNumbersAsTextAsTheyStandInTheFile) {
  EXPECT_THAT(parseCsv("session\n007\n1.50\n").text("session"), ElementsAre("007", "1.50"));
}

TEST(Csv, ReadsQuotesCarriageReturnsAndAByteOrderMark) {
  const CsvTable table = parseCsv("\xEF\xBB\xBF\"a, b\",x\r\n\"say \"\"hi\"\"\",\"1.5\"\r\n\"two\nlines\",2\r\nend,3");
  EXPECT_THAT(table.columns(), ElementsAre("a, b", "x"));
  EXPECT_THAT(table.text("a, b"), ElementsAre("say \"hi\"", "two\nlines", "end"));
  EXPECT_THAT(table.quantity("x", ""), ElementsAre(1.5, 2.0, 3.0));
  EXPECT_EQ(table.lineOf(1), 3u);
  EXPECT_EQ(table.lineOf(2), 5u);  // the row before takes two lines
}

TEST(Csv, RefusesUtf16) {
  using namespace std::string_literals;
  for (const std::string& mark : {"\xFF\xFE"s, "\xFE\xFF"s}) {
    EXPECT_THAT(parseSentence(mark + "t\0i\0"s), ::testing::HasSubstr("log.csv:1: found UTF-16 text, expected UTF-8"));
  }
}

TEST(Csv, TakesEmptyLinesAtTheEndOnly) {
  EXPECT_EQ(parseCsv("a,b\n1,2\n\r\n\n").rows(), 1u);
  EXPECT_EQ(parseCsv("a,b\n1,2").rows(), 1u);
  EXPECT_EQ(parseSentence("a,b\n1,2\n\n3,4\n"), "log.csv:3: found 1 cells, expected 2");
}

TEST(Csv, TakesAnEmptyCellAtTheEndOfTheText) {
  EXPECT_THAT(parseCsv("a,b\n1,").text("b"), ElementsAre(""));
  EXPECT_THAT(parseCsv("a,b\n1,\n").text("b"), ElementsAre(""));
}

// As a PLC and LabVIEW write them.
TEST(Csv, ASeparatorMayEndALine) {
  for (const std::string text : {"a_m;b;\n1;2;\n3;4;\n", "a_m;b\n1;2;\n3;4;", "a_m;b;\n1;2\n3;4\n"}) {
    const CsvTable table = parseCsv(text);
    EXPECT_THAT(table.columns(), ElementsAre("a_m", "b")) << text;
    EXPECT_THAT(table.quantity("a", "m"), ElementsAre(1.0, 3.0)) << text;
    EXPECT_THAT(table.text("b"), ElementsAre("2", "4")) << text;
  }
  EXPECT_EQ(parseSentence("a,b,\n1,2,3\n"), "log.csv:2: found 3 cells, expected 2");
  EXPECT_EQ(parseSentence("a,b\n1,2,,\n"), "log.csv:2: found 4 cells, expected 2");
}

TEST(Csv, SaysThatATitleIsNoHeader) {
  EXPECT_EQ(parseSentence("rig 3\nt,i\n0,1\n"),
            "log.csv:2: found 2 cells, expected 1: line 1 has to name the columns; is it a title?");
}

TEST(Csv, MayHoldAHeaderOnly) {
  const CsvTable table = parseCsv("a_m,b\n");
  EXPECT_EQ(table.rows(), 0u);
  EXPECT_THAT(table.quantity("a", "m"), IsEmpty());
  EXPECT_THAT(table.text("b"), IsEmpty());
}

TEST(Csv, RefusesABrokenHeader) {
  EXPECT_EQ(parseSentence(""), "log.csv:1: found an empty file, expected a header row");
  EXPECT_EQ(parseSentence("\n\n"), "log.csv:1: found an empty file, expected a header row");
  EXPECT_EQ(parseSentence("a,b,a\n"), "log.csv:1: found the column a twice, expected it once");
  EXPECT_EQ(parseSentence("a,,c\n"), "log.csv:1: column 2 of the header has no name, expected one");
}

TEST(Csv, RefusesBrokenRowsWithTheirLine) {
  EXPECT_EQ(parseSentence("a,b\n1,2\n3\n"), "log.csv:3: found 1 cells, expected 2");
  EXPECT_EQ(parseSentence("a,b\n1,2,3\n"), "log.csv:2: found 3 cells, expected 2");
  EXPECT_EQ(parseSentence("a\nx\"y\n"),
            "log.csv:2: found a quote inside a cell without quotes, expected the whole cell quoted");
  EXPECT_EQ(parseSentence("a\n1\n\"x\ny"), "log.csv:3: found a quoted cell without an end, expected a closing quote");
  EXPECT_EQ(parseSentence("a\n\"x\"y\n"),
            "log.csv:2: found text behind a closing quote, expected a comma or the end of the line");
  EXPECT_EQ(parseSentence("a,b\r1,2\r"), "log.csv:1: found a carriage return without a line feed, expected both");
}

TEST(Csv, SemicolonsAndTabsSeparateWhereTheHeaderHasThem) {
  for (const std::string separator : {";", "\t"}) {
    const auto text = [&](std::string commas) {
      for (std::size_t at = 0; (at = commas.find('|', at)) != std::string::npos;) commas.replace(at, 1, separator);
      return commas;
    };
    const CsvTable table = parseCsv(text("\"a, b, c\"|x_m|note\n1.5|2|good, really\n-3|4e-1|\"|\"\n"));
    EXPECT_THAT(table.columns(), ElementsAre("a, b, c", "x_m", "note"));
    EXPECT_THAT(table.quantity("x", "m"), ElementsAre(2.0, 0.4));
    EXPECT_THAT(table.text("note"), ElementsAre("good, really", separator));
    EXPECT_EQ(parseSentence(text("a|b\n1\n")), "log.csv:2: found 1 cells, expected 2");
  }
  EXPECT_EQ(parseSentence("a;b\n\"x\"y;1\n"),
            "log.csv:2: found text behind a closing quote, expected a semicolon or the end of the line");
  EXPECT_THAT(parseCsv("force [N; raw],t\n1,2\n").columns(), ElementsAre("force [N; raw]", "t"));
}

TEST(Csv, DecimalCommasStandWhereCommasDoNotSeparate) {
  const CsvTable table = parseCsv("x_m;n;note\n1,5;7;a,b\n-0,25;8;c\n\"2,0\";+1,5e3;d\n");
  EXPECT_THAT(table.quantity("x", "m"), ElementsAre(1.5, -0.25, 2.0));
  EXPECT_THAT(table.quantity("n", ""), ElementsAre(7.0, 8.0, 1500.0));
  EXPECT_THAT(table.text("note"), ElementsAre("a,b", "c", "d"));
  EXPECT_THAT(parseCsv("x\ty\n1,5\t2\n").quantity("x", ""), ElementsAre(1.5));
  EXPECT_EQ(quantitySentence("x;y\n1,5;1\n2.5;1\n", "x", ""),
            "log.csv:3: column x: found '2.5', expected a finite number with a decimal comma, as other numbers of the "
            "file have it");
  EXPECT_THAT(quantitySentence("x;y\n1,5;1\n1.234,5;1\n", "x", ""), ::testing::HasSubstr("found '1.234,5',"));
}

TEST(CsvRename, MultipliesByAFactor) {
  CsvOptions options;
  options.rename = {{"load_N", "sensor"}};
  options.scale = {{"load_N", -0.001}};
  EXPECT_THAT(parseCsv("sensor,t\n2000,1\n-500,2\n", options).quantity("load", "N"), ElementsAre(-2.0, 0.5));
  EXPECT_EQ(csvSentence([&] { parseCsv("sensor,t\nlow,1\n", options); }),
            "log.csv:1: column load_N is to be multiplied, expected numbers in it");
}

TEST(CsvQuantity, OffersNoColumnWhoseUnitItWouldDrop) {
  const CsvTable table = parseCsv("load_lbf,speed_rad_s,speed_ref,angle,force_ref\n1,2,3,4,5\n");
  EXPECT_TRUE(table.offersQuantity("speed", "rad_s"));
  EXPECT_FALSE(table.offersQuantity("current", "A"));
  EXPECT_FALSE(table.offersQuantity("force", "N"));  // a reference, whatever its unit
  EXPECT_EQ(csvSentence([&] { table.offersQuantity("load", "N"); }),
            "log.csv:1: column load_lbf: unit 'lbf' does not exist, expected one of N, mN, kN");
  EXPECT_EQ(csvSentence([&] { table.offersQuantity("angle", "rad"); }),
            "log.csv:1: column angle: unit is missing, expected one of rad, deg");
}

TEST(Csv, LeavesOutRowsOnDemand) {
  const CsvTable table = parseCsv("x,note\n1,a\nnan,b\n3,\"c\nd\"\n,e\n5,f\n");
  EXPECT_THAT(table.badRows("x"), ElementsAre(1u, 3u));
  EXPECT_THAT(table.badRows("note"), IsEmpty());
  const CsvTable rest = table.onlyRows({true, false, true, false, true});
  EXPECT_THAT(rest.quantity("x", ""), ElementsAre(1.0, 3.0, 5.0));
  EXPECT_THAT(rest.text("note"), ElementsAre("a", "c\nd", "f"));
  EXPECT_EQ(rest.lineOf(2), 7u);
  EXPECT_EQ(table.rows(), 5u);
}

TEST(CsvQuantity, ConvertsEveryUnitToTheAskedOne) {
  const CsvTable table = parseCsv("shaft_deg,t_K,n_rpm\n180,293.15,60\n");
  EXPECT_DOUBLE_EQ(table.quantity("shaft", "rad")[0], 3.14159265358979323846);
  EXPECT_NEAR(table.quantity("t", "degC")[0], 20.0, 1e-12);
  EXPECT_DOUBLE_EQ(table.quantity("n", "rad_s")[0], 2.0 * 3.14159265358979323846);
  EXPECT_TRUE(table.hasQuantity("shaft", "rad"));
  EXPECT_FALSE(table.hasQuantity("shaft", "m"));
  EXPECT_TRUE(table.hasQuantity("shaft_deg", ""));
}

TEST(CsvQuantity, TakesEveryNotationOfANumber) {
  EXPECT_THAT(parseCsv("x\n+5\n1E3\n-.5\n2.\n\"4\"\n").quantity("x", ""), ElementsAre(5.0, 1000.0, -0.5, 2.0, 4.0));
}

TEST(CsvQuantity, NamesTheLineOfTheFirstBadCell) {
  const auto sentence = [](const std::string& cell) {
    return quantitySentence("elbow_rad,x\n1.0,1\n" + cell + ",1\nnan,1\n", "elbow", "rad");
  };
  const std::string place = "log.csv:3: column elbow_rad: ";
  EXPECT_EQ(sentence(""), place + "found an empty cell, expected a finite number");
  EXPECT_EQ(sentence("\"\""), place + "found an empty cell, expected a finite number");
  for (const std::string cell : {"nan", "NaN", "inf", "-inf", "+inf", "Infinity", "1e999", "abc", "0x10", " 5", "5 ",
                                 "+-5", "1e", "1.2.3", "1;5"}) {
    EXPECT_EQ(sentence(cell), place + "found '" + cell + "', expected a finite number");
  }
  EXPECT_EQ(sentence("\"1,5\""), place + "found '1,5', expected a finite number");
}

TEST(CsvQuantity, NamesABadCellInTheFirstRow) {
  for (const std::string cell : {"abc", "nan", "inf"}) {
    EXPECT_EQ(quantitySentence("x_m,y\n" + cell + ",1\n2,1\n", "x", "m"),
              "log.csv:2: column x_m: found '" + cell + "', expected a finite number");
  }
  EXPECT_EQ(quantitySentence("x_m,y\n,1\n2,1\n", "x", "m"),
            "log.csv:2: column x_m: found an empty cell, expected a finite number");
}

TEST(CsvQuantity, NamesTheUnitThatDoesNotFit) {
  EXPECT_EQ(quantitySentence("pose,shaft_biceps_furlong\n", "shaft_biceps", "rad"),
            "log.csv:1: column shaft_biceps_furlong: unit 'furlong' does not exist, expected one of rad, deg");
  EXPECT_EQ(quantitySentence("pose,shaft_biceps_m\n", "shaft_biceps", "rad"),
            "log.csv:1: column shaft_biceps_m: unit 'm' is of another kind, expected one of rad, deg");
  EXPECT_EQ(quantitySentence("pose,shaft_biceps\n", "shaft_biceps", "rad"),
            "log.csv:1: column shaft_biceps: unit is missing, expected one of rad, deg");
}

TEST(CsvQuantity, NamesTheMissingColumnAndTheOnesThere) {
  EXPECT_EQ(quantitySentence("pose,elbow_rad_s\n", "knee", "rad"),
            "log.csv:1: found no column knee_rad or knee_deg, expected it among pose, elbow_rad_s");
  EXPECT_EQ(quantitySentence("pose,x\n", "contraction", ""),
            "log.csv:1: found no column contraction, expected it among pose, x");
  EXPECT_EQ(csvSentence([] { parseCsv("a,b\n").text("pose"); }),
            "log.csv:1: found no column pose, expected it among a, b");
  const CsvOptions options{.missing_advice = "; this may help"};
  EXPECT_EQ(csvSentence([&] { CsvTable::parse("a,b\n", "log.csv", options).text("pose"); }),
            "log.csv:1: found no column pose, expected it among a, b; this may help");
}

TEST(CsvQuantity, RefusesAQuantityInTwoUnits) {
  EXPECT_EQ(quantitySentence("elbow_rad,elbow_deg\n", "elbow", "rad"),
            "log.csv:1: found both elbow_rad and elbow_deg, expected only one of them");
}

TEST(CsvFail, NamesTheLineOfTheRow) {
  const CsvTable table = parseCsv("a,b\n\"x\ny\",1\nz,2\n");
  EXPECT_EQ(csvSentence([&] { table.fail(1, "the time does not increase"); }), "log.csv:4: the time does not increase");
}

TEST(CsvRename, ReadsAColumnUnderItsCanonicalName) {
  const CsvTable table = parseCsv("ang,t\n90,1\n", {false, {{"elbow_deg", "ang"}}});
  EXPECT_THAT(table.columns(), ElementsAre("elbow_deg", "t"));
  EXPECT_TRUE(table.hasQuantity("elbow", "rad"));
  const CsvTable swapped = parseCsv("a,b\n1,2\n", {false, {{"a", "b"}, {"b", "a"}}});
  EXPECT_THAT(swapped.quantity("a", ""), ElementsAre(2.0));
}

TEST(CsvRename, RefusesWhatCannotBeRenamed) {
  const auto sentence = [](const std::map<std::string, std::string>& rename) {
    return csvSentence([&] { parseCsv("a,b\n", {false, rename}); });
  };
  EXPECT_EQ(sentence({{"x", "c"}}), "log.csv:1: found no column c to read as x, expected one of a, b");
  EXPECT_EQ(sentence({{"b", "a"}}), "log.csv:1: found the column b twice, expected it once");
  EXPECT_EQ(sentence({{"x", "a"}, {"y", "a"}}), "log.csv:1: the column a cannot be both x and y");
}

TEST(CsvSkipBadRows, DropsAndCountsThem) {
  const CsvTable table = parseCsv("t,x,note\n1,nan,a\n2,5,b\n3,,c\n4\n5,inf,d\n6,oops,e\n7,8,\n8,9,f,g\n", {true, {}});
  EXPECT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.skippedRows(), 6u);
  EXPECT_THAT(table.quantity("x", ""), ElementsAre(5.0, 8.0));
  EXPECT_THAT(table.quantity("t", ""), ElementsAre(2.0, 7.0));
  EXPECT_THAT(table.text("note"), ElementsAre("b", ""));
  EXPECT_EQ(table.lineOf(1), 8u);
}

TEST(CsvSkipBadRows, LearnsNothingAboutAColumnFromARaggedRow) {
  const CsvTable table = parseCsv("x,y\n# made today\n,1\noops\n5,2\n", {true, {}});
  EXPECT_EQ(table.skippedRows(), 3u);
  EXPECT_THAT(table.quantity("x", ""), ElementsAre(5.0));
  EXPECT_THAT(table.quantity("y", ""), ElementsAre(2.0));
}

TEST(CsvSkipBadRows, LeavesAGoodTableAlone) {
  const CsvTable table = parseCsv("x\n1\n2\n", {true, {}});
  EXPECT_EQ(table.skippedRows(), 0u);
  EXPECT_THAT(table.quantity("x", ""), ElementsAre(1.0, 2.0));
}

TEST(CsvLoad, ReadsPlainAndPackedFiles) {
  const std::string text = "a,b\n1,2\n3,4\n";
  const TemporaryFile plain("plain.csv", text);
  const TemporaryFile packed("packed.csv.gz", test::gzipped(text));
  EXPECT_THAT(CsvTable::load(plain.path()).quantity("b", ""), ElementsAre(2.0, 4.0));
  EXPECT_THAT(CsvTable::load(packed.path()).quantity("b", ""), ElementsAre(2.0, 4.0));
  EXPECT_EQ(CsvTable::load(plain.path()).name(), plain.path().string());
}

TEST(CsvLoad, RefusesWhatItCannotRead) {
  // A path that leads to no file is a slip on the command line, not bad data.
  EXPECT_THROW(CsvTable::load("no/such.csv"), ConfigError);
  EXPECT_THROW(CsvTable::load(std::filesystem::temp_directory_path()), ConfigError);
  const TemporaryFile unpacked("unpacked.csv.gz", "a,b\n1,2\n");
  EXPECT_EQ(csvSentence([&] { CsvTable::load(unpacked.path()); }),
            unpacked.path().string() + ":1: found no gzip data, expected them by the name's ending");
}

TEST(CsvLoad, RefusesTruncatedAndDamagedGzip) {
  std::mt19937 random(6);
  std::string text = "a,b\n";
  for (int i = 0; i < 1000; ++i) text += std::to_string(random()) + "," + std::to_string(random()) + "\n";
  const std::string packed = test::gzipped(text);
  const auto sentence = [](const std::string& content) {
    const TemporaryFile file("broken.csv.gz", content);
    const std::string found = csvSentence([&] { CsvTable::load(file.path()); });
    EXPECT_TRUE(found.starts_with(file.path().string() + ":")) << found;
    return found;
  };
  EXPECT_THAT(sentence(packed.substr(0, packed.size() / 2)),
              ::testing::ContainsRegex(":[0-9]+: the gzip data break off here, expected the rest of the file"));
  EXPECT_THAT(sentence(packed.substr(0, packed.size() - 3)),
              ::testing::ContainsRegex(":1002: the gzip data break off here, expected the rest of the file"));
  std::string damaged = packed;
  for (std::size_t i = damaged.size() / 2; i < damaged.size() / 2 + 64; ++i) damaged[i] = '\xFF';
  EXPECT_THAT(sentence(damaged),
              ::testing::ContainsRegex(":[0-9]+: the gzip data are damaged here, expected a valid stream"));
}

TEST(CsvQuantity, RefusesWhatIsAbsurd) {
  EXPECT_EQ(quantitySentence("a_deg\n1\n1e20\n", "a", "rad"),
            "log.csv:3: column a_deg: found 1e+20, expected a size of at most 5.72958e+09 deg: is that the unit?");
  EXPECT_EQ(quantitySentence("T_K\n-1e9\n", "T", "degC"),
            "log.csv:2: column T_K: found -1e+09, expected a size of at most 100000 K: is that the unit?");
  EXPECT_EQ(quantitySentence("a_rad\n99999999\n", "a", "rad"), "no error");
}

TEST(CsvLoad, UnpacksNoMoreThanItMay) {
  const std::string packed = test::gzipped("a\n" + std::string(5 << 20, '0') + "\n");
  EXPECT_LT(packed.size(), 10'000u);
  EXPECT_EQ(csvSentence([&] { unpackCsv(packed, "bomb.csv.gz", 4 << 20); }),
            "bomb.csv.gz: found more than 4 MiB of unpacked text, expected less");
  EXPECT_EQ(unpackCsv(packed, "good.csv.gz", 6 << 20).size(), (5u << 20) + 3);
}

// A bomb below the limit of 4 GiB took all of it before it was refused.
TEST(CsvLoad, NoTableIsAsDenseAsThis) {
  const std::string packed = test::gzipped("a\n" + std::string(80 << 20, '0') + "\n");
  EXPECT_EQ(csvSentence([&] { unpackCsv(packed, "bomb.csv.gz", std::size_t{4} << 30U); }),
            "bomb.csv.gz: found gzip data that unpack to more than 200 times their size, expected a table (rows of one "
            "take a few bytes each)");
}

// The check of the header was quadratic: 50,000 columns took 19 s, these would outlast ctest's limit.
TEST(CsvParse, ReadsManyColumns) {
  std::string text;
  for (int i = 0; i < 400'000; ++i) text += "column" + std::to_string(i) + ",";
  text.back() = '\n';
  EXPECT_EQ(parseCsv(text).columns().size(), 400'000u);
  EXPECT_EQ(parseSentence("column1," + text), "log.csv:1: found the column column1 twice, expected it once");
}

}  // namespace
}  // namespace simgap
