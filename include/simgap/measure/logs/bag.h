/// \file
/// Recorded topics of a robot as a log's table: MCAP, and the SQLite files of rosbag2.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/csv.h"

namespace simgap {

/// True for bytes that begin as MCAP or SQLite files do.
bool isBag(std::string_view bytes);

struct BagLog {
  CsvTable table;                  ///< `time_s` from 0, then a column per number; line N + 2 is its row N
  std::vector<std::string> notes;  ///< sentences about what was left out
};

/// Numbers of chosen topics, at the times of the first topic's messages: `JOINT.position`, `.velocity`, `.effort` of a
/// sensor_msgs/JointState, the topic's name without its first slash for a std_msgs/Float64 or Float32, `NAME.0` and so
/// on for the arrays of these. A column that two topics have is called TOPIC:COLUMN. Times are the stamps of the
/// headers where every message has one, those of the recorder otherwise. Other topics are interpolated linearly; a cell
/// is empty in a gap of more than ten of a column's usual intervals, and rows outside the time that all columns have
/// are left out. \param bytes  of the whole file. \param name  stands for it in errors. \param topics  "NAME", or
/// "NAME:FIELD" for the columns that are called FIELD, begin with "FIELD." or end in ".FIELD" \throws DataError: a
/// damaged, truncated or oversized file; a topic that is missing (lists those there are), holds
///         nothing, or has another type or encoding; a field that is missing; topics of different times.
/// \throws ConfigError: no topic.
BagLog readBag(std::string bytes, const std::string& name, std::span<const std::string> topics,
               const CsvOptions& options = {});

/// Every topic whose messages readBag can read. \throws DataError as readBag
std::vector<std::string> readableTopics(std::string bytes, const std::string& name);

}  // namespace simgap
