#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "report/capture/capture_tables.h"
#include "simgap/core/error.h"
#include "simgap/core/json_numbers.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::capture {
namespace {

constexpr std::size_t kMostFrames = 100;  // of the three-dimensional view

// Of the charts, whose lines hold 2,000 points: the page of a longer recording takes no more memory.
constexpr std::size_t kMostPairs = 2'500;

/// Of how many pairs the charts show one.
std::size_t strideOf(const Json& result) {
  return 1 + static_cast<std::size_t>(wholeNumber(result.at("pairs"))) / kMostPairs;
}

/// The head of a table and the lines of it that are wanted. \param wanted  asked line by line
template <class Wanted>
CsvTable linesOf(const ResultFiles& files, const char* name, const Wanted& wanted) {
  if (!files.has(name)) return files.table(name);  // says so
  std::ifstream file(files.directory() / name);
  file.exceptions(std::ios::badbit);  // no memory for a line is no end of the file
  std::string text, line;
  std::getline(file, text);
  while (std::getline(file, line)) {
    if (wanted(line)) text.append("\n").append(line);
  }
  return CsvTable::parse(text + "\n", name);
}

/// A table whose first column is the pair's number, of one in `stride` pairs.
CsvTable pairsTable(const ResultFiles& files, const char* name) {
  const std::size_t stride = strideOf(files.result());
  if (stride == 1) return files.table(name);
  return linesOf(files, name,
                 [stride](const std::string& line) { return std::strtoull(line.c_str(), nullptr, 10) % stride == 0; });
}

/// The first poses of poses.csv, and how many there are.
struct Poses {
  std::size_t count = 0;
  CsvTable shown;

  explicit Poses(const ResultFiles& files)
      : shown(linesOf(files, "poses.csv", [this](const std::string&) { return ++count <= kMostPosesShown; })) {}
  bool all() const { return count <= kMostPosesShown; }
};

/// frames.csv: a row per target and frame where it was found.
struct Frames {
  std::vector<std::string> target;
  std::vector<double> frame, time, visible, rms, epipolar;
  double stride;

  Frames(const CsvTable& table, std::size_t one_in)
      : target(table.text("target")),
        frame(numbersOf(table, "frame")),
        time(numbersOf(table, "time_s")),
        visible(numbersOf(table, "visible")),
        rms(numbersOf(table, "rms_mm")),
        epipolar(numbersOf(table, "epipolar_px")),
        stride(static_cast<double>(one_in)) {}

  /// A column of one target over time.
  Series series(const std::string& name, const std::vector<double>& column) const {
    Series line{name, {}, {}};
    double last = 0.0;
    for (std::size_t i = 0; i < target.size(); ++i) {
      if (target[i] != name) continue;
      if (!line.x.empty() && frame[i] > last + stride) {  // frames without the target
        line.x.push_back(time[i]);
        line.y.push_back(std::nan(""));
      }
      line.x.push_back(time[i]);
      line.y.push_back(column[i]);
      last = frame[i];
    }
    return line;
  }
};

std::vector<std::string> targetNames(const Json& result) {
  std::vector<std::string> names;
  for (const Json& target : result.at("targets")) names.push_back(target.at("name"));
  return names;
}

/// Shares of the values in bins over the range that holds all but the outermost percent.
Chart histogram(const std::string& caption, const std::string& title, const std::vector<Series>& values) {
  constexpr std::size_t kBins = 30;
  std::vector<double> all;
  for (const Series& series : values)
    std::ranges::copy_if(series.y, std::back_inserter(all), [](double v) { return std::isfinite(v); });
  if (all.empty()) all.push_back(0.0);
  std::ranges::sort(all);
  const auto quantile = [&](double q) {
    return all[static_cast<std::size_t>(q * static_cast<double>(all.size() - 1))];
  };
  const double low = std::min(quantile(0.005), 0.0), high = std::max(quantile(0.995), low + 1e-12);
  std::vector<Series> shares;
  for (const Series& series : values) {
    Series share{series.name, {}, std::vector<double>(kBins, 0.0)};
    double count = 0.0;
    for (const double v : series.y) {
      if (!std::isfinite(v)) continue;
      const double place = std::clamp((v - low) / (high - low), 0.0, 1.0) * static_cast<double>(kBins);
      share.y[std::min(static_cast<std::size_t>(place), kBins - 1)] += 1.0;
      count += 1.0;
    }
    for (double& bin : share.y) bin *= 100.0 / std::max(count, 1.0);
    shares.push_back(share);
  }
  std::vector<std::string> labels;
  for (std::size_t b = 0; b < kBins; ++b) {
    labels.push_back(fmt::format("{:.3f}", low + (static_cast<double>(b) + 0.5) * (high - low) / kBins));
  }
  Chart chart = barChart(caption, labels, {"share [%]"}, shares);
  chart.spec["x"] = {{"title", title}, {"log", false}};
  return chart;
}

/// Joint angles over time, with the windows in which the arm rested.
Chart angleChart(const ResultFiles& files, bool all_poses) {
  const CsvTable table = pairsTable(files, "joints.csv");
  const std::vector<double> time = numbersOf(table, "time_s");
  std::vector<Series> lines;
  for (const auto& [joint, type] : files.result().at("joint_types").items()) {
    lines.push_back({joint, time, jointAngles(table, joint)});
  }
  Chart chart = lineChart("Joint angles", {"time [s]"}, {"angle [deg]"}, lines);
  chart.note = "Of a spherical joint: the angle from its zero pose. ";
  chart.note += all_poses ? "Shaded: the arm rests there, and each rest is a pose."
                          : fmt::format("The first {} rests are shaded.", kMostPosesShown);
  chart.spec["bands"] = Json::array();
  for (const Json& pose : files.result().at("poses")) {
    chart.spec["bands"].push_back({pose.at("start_s"), pose.at("end_s")});
  }
  chart.wide = true;
  makeZoomable(chart);
  return chart;
}

/// The markers where the fitted targets put them, in the left camera's frame.
PageScene markerScene(const ResultFiles& files, const Frames& frames) {
  const CsvTable table = pairsTable(files, "frames.csv");
  std::array<std::vector<double>, 7> frame;
  const std::array<const char*, 7> names = {"qw", "qx", "qy", "qz", "x_m", "y_m", "z_m"};
  for (std::size_t k = 0; k < 7; ++k) frame[k] = numbersOf(table, names[k]);
  const std::vector<std::string> targets = targetNames(files.result());
  std::vector<double> numbers = frames.frame;
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  const std::size_t stride = 1 + numbers.size() / kMostFrames;
  Json poses = Json::array();
  const auto shortNumber = [](double v) { return std::round(1e4 * v) / 1e4; };
  std::size_t row = 0;
  for (std::size_t n = 0; n < numbers.size(); n += stride) {
    while (row < frames.frame.size() && frames.frame[row] != numbers[n]) ++row;
    if (row == frames.frame.size())
      throw DataError("frames.csv: found a frame without a number, or frames out of order");
    Json markers = Json::array();
    const double time = frames.time[row];
    for (; row < frames.frame.size() && frames.frame[row] == numbers[n]; ++row) {
      const auto t = static_cast<std::size_t>(std::ranges::find(targets, frames.target[row]) - targets.begin());
      const Eigen::Quaterniond rotation(frame[0][row], frame[1][row], frame[2][row], frame[3][row]);
      const Eigen::Vector3d origin(frame[4][row], frame[5][row], frame[6][row]);
      for (const Json& marker : files.result().at("targets").at(t).at("markers_m")) {
        const Eigen::Vector3d at = rotation * Eigen::Vector3d(marker.at(0), marker.at(1), marker.at(2)) + origin;
        // The camera's y points down and its z away: shown upright, as the camera sees it.
        markers.push_back({t, shortNumber(at.z()), shortNumber(-at.x()), shortNumber(-at.y())});
      }
    }
    poses.push_back(
        {{"name", fmt::format("{:.3f} s", time)},
         {"states",
          {{"markers",
            {{"text", fmt::format("{} markers", markers.size())}, {"bodies", Json::array()}, {"markers", markers}}}}}});
  }
  PageScene scene{"The markers in space", "", {}};
  scene.note = "Where the fitted targets put them, one colour per target. Drag or use the arrow keys to turn.";
  scene.scene = {{"slider", "time"},         {"groups", targets},
                 {"states", {"markers"}},    {"ghost", nullptr},
                 {"bodies", Json::array()},  {"parts", Json::array()},
                 {"most_tension", 0},        {"marker_radius", files.result().at("marker_radius_m")},
                 {"look", {-1.0, 0.3, 0.3}}, {"poses", poses}};
  return scene;
}

Table distanceTable(const ResultFiles& files) {
  const CsvTable csv = files.table("distances.csv");
  Table table{"Distances [mm]", {"markers", "nominal", "mean", "sd", "predicted sd"}, {}, true};
  const auto target = csv.text("target"), markers = csv.text("markers");
  const auto nominal = numbersOf(csv, "nominal_mm"), mean = numbersOf(csv, "mean_mm");
  const auto sd = numbersOf(csv, "sd_mm"), predicted = numbersOf(csv, "predicted_sd_mm");
  for (std::size_t i = 0; i < target.size(); ++i) {
    table.rows.push_back({target[i] + " " + markers[i], fmt::format("{:.3f}", nominal[i]),
                          fmt::format("{:.3f}", mean[i]), fmt::format("{:.4f}", sd[i]),
                          fmt::format("{:.4f}", predicted[i])});
  }
  return table;
}

Chart distanceHistogram(const ResultFiles& files) {
  const CsvTable csv = files.table("histogram.csv");
  Chart chart = barChart("Distances between markers of a target", csv.text("error_mm"), {"pairs of markers"},
                         {{"measured - nominal", {}, numbersOf(csv, "count")}});
  chart.spec["x"] = {{"title", "measured - nominal distance [mm]"}, {"log", false}};
  return chart;
}

PageVerdict verdictOf(const ResultFiles& files) {
  constexpr double kMostLost = 0.05;
  const Json& result = files.result();
  const double pairs = numberOf(result.at("pairs")), seen = numberOf(result.at("pairs_with_all_joints"));
  PageVerdict verdict{PageVerdict::Level::kGood, "good", "Nothing speaks against the geometry.",
                      files.has("poses.csv") && !result.at("poses").empty()
                          ? fmt::format("simgap calibrate ARM.yaml --poses {}", files.path("poses.csv"))
                          : fmt::format("simgap calibrate-joints {} --frames {}", files.input("rig", "RIG.yaml"),
                                        files.path("frames.csv"))};
  if (seen < (1.0 - kMostLost) * pairs) {
    verdict.level = PageVerdict::Level::kDoubtful;
    verdict.words = fmt::format("{:.0f} of {:.0f} pairs", seen, pairs);
    verdict.cause = "In the others a target was not found, so that joints are missing.";
  }
  if (!result.at("geometry").at("findings").empty()) {
    verdict.level = PageVerdict::Level::kBad;
    verdict.words = "the geometry is in doubt";
    verdict.cause = "Joint angles can be wrong by more than their deviations say.";
  }
  return verdict;
}

/// What was found in single pairs, as the run drew it.
void addOverlays(const ResultFiles& files, Page& page) {
  constexpr std::size_t kMost = 1;  // each is two thirds of a megabyte
  std::vector<std::filesystem::path> pictures;
  for (const auto& entry : std::filesystem::directory_iterator(files.directory())) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("overlay_") && name.ends_with(".png")) pictures.push_back(entry.path());
  }
  std::ranges::sort(pictures);
  pictures.resize(std::min(pictures.size(), kMost));
  for (const auto& picture : pictures) {
    page.add(PageImage{"What was found: " + picture.stem().string(), readFile(picture)});
  }
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  const Json& doubts = result.at("geometry").at("findings");
  const Poses poses(files);
  Page page{"simgap capture", captureAnswer(result, poses.count), {}};
  for (const Json& doubt : doubts) page.notes.push_back(doubt.at("sentence"));
  page.verdict = verdictOf(files);
  const std::size_t stride = strideOf(result);
  if (stride > 1) page.notes.push_back(fmt::format("The charts show one in {} pairs; tables count all.", stride));
  const Frames frames(pairsTable(files, "frames.csv"), stride);
  std::vector<Series> visible, rms, epipolar;
  for (const std::string& target : targetNames(result)) {
    visible.push_back(frames.series(target, frames.visible));
    rms.push_back(frames.series(target, frames.rms));
    epipolar.push_back(frames.series(target, frames.epipolar));
  }
  page.add(angleChart(files, poses.all()));
  page.add(markerScene(files, frames));
  addOverlays(files, page);
  page.addSection("How well the targets were seen");
  page.add(lineChart("Visible markers of each target", {"time [s]"}, {"markers"}, visible));
  page.add(lineChart("Fit of the targets", {"time [s]"}, {"fit RMS [mm]"}, rms));
  page.add(histogram("Fit of the targets, distribution", "fit RMS [mm]", rms));
  page.add(histogram("Epipolar error, distribution", "epipolar error [px]", epipolar));
  page.add(distanceHistogram(files));
  page.add(sightingTable(result));
  page.add(captureFigures(result));
  page.addSection("Poses");
  Table table = poseTable(result, poses.shown);
  if (!poses.all()) table.caption = morePoses(poses.count);
  page.add(std::move(table));
  page.add(distanceTable(files));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/capture/1", make, kMostPosesShown};

}  // namespace simgap::pages::capture
