#include "simgap/measure/logs/bag.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "bag_file.h"
#include "byte_reader.h"
#include "recording.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/text.h"
#include "simgap/core/units.h"

namespace simgap {
namespace bags {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::string_view kMcapBegin = "\x89MCAP"sv, kSqliteBegin = "SQLite format 3\0"sv;
constexpr std::size_t kMostCells = 200'000'000;  // of a table: 2 GB of text
constexpr double kMostIntervals = 10.0;          // a longer gap is not bridged
constexpr double kNanosecond = 1e-9;             // [s]
constexpr std::size_t kRowsBetweenLooks = 4096;

std::vector<BagTopic> readFileOf(std::string& bytes, const std::string& name, const TakeMessage& take) {
  if (bytes.starts_with(kSqliteBegin)) return readRosbag2(bytes, name, take);
  return readMcap(bytes, name, take);
}

std::string listOf(const std::vector<BagTopic>& topics) {
  std::map<std::string, std::string> lines;
  for (const BagTopic& topic : topics) {
    lines[topic.name] = fmt::format("{} ({}, {} messages)", topic.name,
                                    topic.type.empty() ? topic.encoding : topic.type, topic.messages);
  }
  std::vector<std::string> all;
  for (const auto& [topic, line] : lines) all.push_back(line);
  return all.empty() ? "none" : fmt::format("{}", fmt::join(all, ", "));
}

std::string meant(const std::string& name, std::span<const std::string> names) {
  const std::string nearest = nearestName(name, names);
  return nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest);
}

/// "NAME:FIELD"; names of topics have no colon.
std::vector<Recording> recordingsFor(std::span<const std::string> topics) {
  std::vector<Recording> recordings;
  for (const std::string& text : topics) {
    const std::size_t colon = text.rfind(':');
    const std::string topic = text.substr(0, colon);
    auto found = std::ranges::find(recordings, topic, &Recording::topic);
    if (found == recordings.end()) found = recordings.insert(recordings.end(), Recording(topic));
    found->addField(colon == std::string::npos ? "" : text.substr(colon + 1));
  }
  return recordings;
}

/// \throws DataError: a type or an encoding that cannot be read, a damaged message; each with its topic
void takeMessage(Recording& recording, const std::string& file, const BagTopic& topic, std::int64_t time,
                 std::string_view data) {
  if (!isReadable(topic)) {
    throw DataError(fmt::format("{}: {}: found {} as {}, expected {}", file, topic.name,
                                topic.type.empty() ? "no type" : topic.type,
                                topic.encoding.empty() ? "no encoding" : topic.encoding, readableTypes()));
  }
  try {
    recording.take(topic, time, data);
  } catch (const Malformed& error) {
    throw DataError(fmt::format("{}: {}: message {}: {}", file, topic.name, topic.messages, error.what()));
  }
}

void requireRecorded(const std::vector<Recording>& recordings, const std::vector<BagTopic>& topics,
                     const std::string& file) {
  std::vector<std::string> names;
  for (const BagTopic& topic : topics) names.push_back(topic.name);
  for (const Recording& recording : recordings) {
    if (std::ranges::find(names, recording.topic()) == names.end()) {
      throw DataError(fmt::format("{}: found no topic {}, expected one of {}{}", file, recording.topic(),
                                  listOf(topics), meant(recording.topic(), names)));
    }
    if (recording.messages() == 0) {
      throw DataError(
          fmt::format("{}: found no message of {}, expected some: {}", file, recording.topic(), listOf(topics)));
    }
    const std::vector<std::string>& columns = recording.allColumns();
    for (const std::string& field : recording.fields()) {
      if (std::ranges::any_of(columns, [&](const auto& name) { return Recording::fits(name, field); })) continue;
      throw DataError(fmt::format("{}: {}: found nothing called {}, expected it among {}{}", file, recording.topic(),
                                  field.empty() ? "at all" : field, listed(columns), meant(field, columns)));
    }
  }
}

/// Of all recordings, the first one's first. Columns that two topics have are called TOPIC:COLUMN.
std::vector<Series> seriesOf(std::vector<Recording>& recordings) {
  const bool stamps = std::ranges::all_of(recordings, &Recording::isStamped);
  std::vector<Series> all;
  std::vector<const std::string*> topic_of;
  std::multiset<std::string> names;
  for (Recording& recording : recordings) {
    for (Series& series : recording.series(stamps)) {
      names.insert(series.column);
      topic_of.push_back(&recording.topic());
      all.push_back(std::move(series));
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (names.count(all[i].column) > 1) all[i].column = fmt::format("{}:{}", *topic_of[i], all[i].column);
  }
  return all;
}

/// Times of all messages that have one of the first topic's columns, rising. \param columns  how many that are
std::vector<std::int64_t> rowTimes(const std::vector<Series>& series, std::size_t columns) {
  std::vector<std::int64_t> times;
  for (std::size_t i = 0; i < columns; ++i) {
    if (i > 0 && series[i].time == series[0].time) continue;  // as a rule: all stand in the same messages
    std::vector<std::int64_t> both;
    std::ranges::set_union(times, series[i].time, std::back_inserter(both));
    times = std::move(both);
  }
  return times;
}

/// Values of a series between its messages, at times that rise.
class Interpolation {
 public:
  explicit Interpolation(const Series& series) : series_(series) {
    std::vector<std::int64_t> steps;
    for (std::size_t i = 1; i < series.time.size(); ++i) steps.push_back(series.time[i] - series.time[i - 1]);
    if (steps.empty()) return;
    const auto middle = steps.begin() + std::ssize(steps) / 2;
    std::ranges::nth_element(steps, middle);
    longest_ = kMostIntervals * static_cast<double>(*middle);
  }

  /// NaN in a gap.
  double at(std::int64_t time) {
    const std::vector<std::int64_t>& times = series_.time;
    while (next_ < times.size() && times[next_] < time) ++next_;
    if (next_ == times.size()) return std::numeric_limits<double>::quiet_NaN();
    if (times[next_] == time) {
      const std::size_t here = next_;
      const bool twice = here + 1 < times.size() && times[here + 1] == time;
      if (twice) ++next_;  // of messages with one stamp each has its row
      return series_.value[here];
    }
    if (next_ == 0) return std::numeric_limits<double>::quiet_NaN();
    const auto gap = static_cast<double>(times[next_] - times[next_ - 1]);
    if (gap > longest_) return std::numeric_limits<double>::quiet_NaN();
    const double part = static_cast<double>(time - times[next_ - 1]) / gap;
    return series_.value[next_ - 1] + part * (series_.value[next_] - series_.value[next_ - 1]);
  }

 private:
  const Series& series_;
  std::size_t next_ = 0;
  double longest_ = 0.0;  ///< [ns]
};

/// The rows in the time that all series have.
std::pair<std::size_t, std::size_t> commonRows(const std::vector<std::int64_t>& times, const std::vector<Series>& all,
                                               const std::string& file) {
  std::int64_t begin = times.front(), end = times.back();
  std::string_view late = all[0].column, early = late;
  for (const Series& series : all) {
    if (series.time.front() > begin) {
      begin = series.time.front();
      late = series.column;
    }
    if (series.time.back() < end) {
      end = series.time.back();
      early = series.column;
    }
  }
  const auto first = std::ranges::lower_bound(times, begin), last = std::ranges::upper_bound(times, end);
  if (first >= last) {
    throw DataError(fmt::format("{}: {} begins when {} has ended, expected columns of the same time", file,
                                abridged(late), abridged(early)));
  }
  return {static_cast<std::size_t>(first - times.begin()), static_cast<std::size_t>(last - times.begin())};
}

std::string csvOf(const std::vector<Series>& all, std::span<const std::int64_t> times, const std::string& file) {
  if (times.size() * (all.size() + 1) > kMostCells) {
    throw DataError(
        fmt::format("{}: found {} columns of {} rows, expected at most {} numbers: choose some by "
                    "--topic NAME:FIELD",
                    file, all.size(), times.size(), kMostCells));
  }
  std::vector<std::string> header = {"time_s"};
  std::vector<Interpolation> columns;
  for (const Series& series : all) {
    header.push_back(series.column);
    columns.emplace_back(series);
  }
  CsvWriter csv(header);
  for (std::size_t row = 0; row < times.size(); ++row) {
    if (row % kRowsBetweenLooks == 0) stopIfInterrupted();
    csv.add(kNanosecond * static_cast<double>(times[row] - times[0]));
    for (Interpolation& column : columns) {
      const double value = column.at(times[row]);
      if (std::isfinite(value)) {
        csv.add(value);
      } else {
        csv.add("");
      }
    }
    csv.endRow();
  }
  return csv.text();
}

}  // namespace
}  // namespace bags

bool isBag(std::string_view bytes) {
  return bytes.starts_with(bags::kMcapBegin) || bytes.starts_with(bags::kSqliteBegin);
}

BagLog readBag(std::string bytes, const std::string& name, std::span<const std::string> topics,
               const CsvOptions& options) {
  std::vector<bags::Recording> recordings = bags::recordingsFor(topics);
  const auto take = [&](const bags::BagTopic& topic, std::int64_t time, std::string_view data) {
    const auto found = std::ranges::find(recordings, topic.name, &bags::Recording::topic);
    if (found != recordings.end()) bags::takeMessage(*found, name, topic, time, data);
  };
  const std::vector<bags::BagTopic> found = bags::readFileOf(bytes, name, take);
  if (topics.empty()) {
    throw ConfigError(
        fmt::format("{}: found a recording and no --topic, expected at least one of {}", name, bags::listOf(found)));
  }
  bags::requireRecorded(recordings, found, name);
  bytes = {};
  const std::size_t first_columns = recordings[0].chosenColumns();
  const std::vector<bags::Series> series = bags::seriesOf(recordings);
  const std::vector<std::int64_t> times = bags::rowTimes(series, first_columns);
  const auto [begin, end] = bags::commonRows(times, series, name);
  BagLog log;
  if (const std::size_t left_out = times.size() - (end - begin); left_out > 0) {
    log.notes.push_back(fmt::format("{}: {} of {} messages of {} left out, at times that other columns do not have",
                                    name, left_out, times.size(), recordings[0].topic()));
  }
  log.table = CsvTable::parse(bags::csvOf(series, std::span(times).subspan(begin, end - begin), name), name, options);
  return log;
}

std::vector<std::string> readableTopics(std::string bytes, const std::string& name) {
  std::set<std::string> names;
  bags::readFileOf(bytes, name, [&](const bags::BagTopic& topic, std::int64_t, std::string_view) {
    if (bags::isReadable(topic)) names.insert(topic.name);
  });
  return {names.begin(), names.end()};
}

}  // namespace simgap
