#include "told_channels.h"

#include <algorithm>
#include <vector>

#include "schedule_line.h"

namespace simgap {

MotionCommands readToldChannels(const CsvTable& table, std::span<const CommandChannel> channels, std::size_t required,
                                bool linear) {
  PoseLayout layout;
  std::vector<Eigen::Index> places;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (i >= required && !table.offersQuantity(channels[i].stem, channels[i].unit)) continue;
    layout.lines.push_back(channels[i]);
    places.push_back(static_cast<Eigen::Index>(i));
  }
  MotionCommands commands = readCommands(table, layout, linear);
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(std::ssize(channels), commands.values.cols());
  values(places, Eigen::all) = commands.values;
  commands.values = std::move(values);
  return commands;
}

MotionCommands readToldChannels(const YamlNode& root, std::span<const CommandChannel> channels, std::size_t required,
                                double rate) {
  root.at("format").oneOf({"simgap/schedule/1"});
  const YamlNode node = root.at("joint");
  std::vector<ScheduleLine> lines(channels.size());
  double end = 0.0;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (i >= required && !node.has(channels[i].stem)) continue;
    lines[i].rate = rate;
    for (const YamlNode& item : node.at(channels[i].stem).at("segments").items()) {
      lines[i].segments.push_back(readSegment(item, lines[i], channels[i].unit));
    }
    end = std::max(end, lines[i].end());
  }
  const double duration = root.findQuantity("duration", "s", kPositive).value_or(end);
  root.expectAllRead();
  const std::size_t rows = scheduleRows(root, duration, rate);
  MotionCommands commands;
  commands.values.resize(std::ssize(channels), rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const double time = static_cast<double>(row) / rate;
    commands.times.push_back(time);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      commands.values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(row)) = lines[i].at(time);
    }
  }
  return commands;
}

}  // namespace simgap
