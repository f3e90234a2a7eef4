/// \file
/// The containers of recorded messages: each hands its messages on, in the order of the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace simgap::bags {

struct BagTopic {
  std::string name;      ///< "/joint_states"
  std::string type;      ///< "sensor_msgs/JointState": without the "msg/" of ROS 2
  std::string encoding;  ///< "cdr", "ros1", "json"
  std::size_t messages = 0;
};

/// \param time_ns  of the recorder, not negative. \param data  valid during the call
using TakeMessage = std::function<void(const BagTopic& topic, std::int64_t time_ns, std::string_view data)>;

/// MCAP (mcap.dev/spec, version 0): messages in chunks, packed with lz4 or zstd or not, or without chunks. Checksums
/// are compared where there are any; the summary behind the data is not read. \returns the topics of the data section.
/// \throws DataError with the byte: truncated, damaged, oversized
std::vector<BagTopic> readMcap(std::string_view bytes, const std::string& file, const TakeMessage& take);

/// The SQLite file of a rosbag2 recording: tables `topics` and `messages`.
/// \param bytes  two of them are changed for SQLite, which is then given the whole file as it stands in memory.
/// \throws DataError: damaged, other tables, more data than the file can hold
std::vector<BagTopic> readRosbag2(std::string& bytes, const std::string& file, const TakeMessage& take);

/// "sensor_msgs/JointState" for "sensor_msgs/msg/JointState".
std::string shortType(std::string_view type);

}  // namespace simgap::bags
