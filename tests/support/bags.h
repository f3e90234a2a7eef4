/// \file
/// A writer of recordings, from the descriptions of the formats (mcap.dev/spec, OMG CDR, wiki.ros.org): it shares
/// nothing with the reader.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace simgap::test {

enum class Wire { kCdrLittle, kCdrBig, kRos1 };

/// \param stamp_ns  of the header
std::string jointState(Wire wire, std::int64_t stamp_ns, const std::vector<std::string>& names,
                       const std::vector<double>& position, const std::vector<double>& velocity,
                       const std::vector<double>& effort);
std::string float64(Wire wire, double value);
std::string float32(Wire wire, float value);
std::string float64Array(Wire wire, const std::vector<double>& values);

struct RecordedMessage {
  std::string topic, type, encoding;  ///< "/a", "std_msgs/msg/Float64", "cdr"
  std::int64_t time_ns;
  std::string data;
};

struct McapStyle {
  std::string compression = "zstd";  ///< "lz4"; "": chunks that are not packed; "no chunks"
  bool checksums = true;
  std::size_t messages_per_chunk = 4;
  bool closed = true;  ///< false: as a recorder leaves it that was killed
};
std::string mcapBytes(const std::vector<RecordedMessage>& messages, const McapStyle& style = {});
/// The parts of a chunk record, for chunks that lie.
std::string mcapChunk(std::string_view compression, std::uint64_t size, std::uint32_t crc, std::string_view packed);
/// A record around its content, and a whole file around records.
std::string mcapRecord(std::uint8_t kind, std::string_view content);
std::string mcapAround(std::string_view records, bool checksum = true);

std::string lz4Packed(std::string_view bytes);
std::string zstdPacked(std::string_view bytes);

/// \param sql  done before the rows go in, in place of the two tables' own definitions when not empty
std::string rosbag2Bytes(const std::vector<RecordedMessage>& messages, const std::string& sql = "");

/// Six messages each of a JointState and a float, 10 ms apart, the floats 5 ms later.
std::vector<RecordedMessage> smallRecording(Wire wire = Wire::kCdrLittle);

}  // namespace simgap::test
