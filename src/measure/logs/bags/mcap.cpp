#include <fmt/format.h>
#include <zlib.h>

#include <limits>
#include <map>
#include <optional>

#include "bag_file.h"
#include "byte_reader.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/text.h"
#include "unpack.h"

namespace simgap::bags {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::string_view kMcapMagic = "\x89MCAP0\r\n"sv;
constexpr std::uint64_t kLargestChunk = std::uint64_t{1} << 30U;  // unpacked; writers make them of about 1 MiB
enum Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kDataEnd = 0x0F
};

std::uint32_t crcOf(std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

struct Record {
  std::uint8_t opcode;
  std::string_view content;
};

Record nextRecord(ByteReader& bytes) {
  const auto opcode = bytes.number<std::uint8_t>("the kind of a record");
  return {opcode, bytes.prefixed<std::uint64_t>("a record")};
}

class McapReader {
 public:
  McapReader(std::string_view bytes, const TakeMessage& take) : bytes_(bytes), all_(bytes), take_(take) {}

  std::vector<BagTopic> read() {
    if (bytes_.take(kMcapMagic.size(), "the beginning") != kMcapMagic) throw Malformed("found no MCAP, expected it");
    if (next().opcode != kHeader) throw Malformed("found no header record at the beginning, expected one");
    while (readDataRecord(next())) stopIfInterrupted();
    requireEnd();
    std::vector<BagTopic> topics;
    for (const auto& [id, topic] : channels_) topics.push_back(topic);
    return topics;
  }

  std::size_t at() const { return record_begin_; }

 private:
  Record next() {
    record_begin_ = bytes_.at();
    if (bytes_.left() == 0) {
      throw Malformed(
          "found the end of the file in the middle of the recording, expected its last record: the recorder "
          "was stopped before it had closed the file (`mcap recover` closes it)");
    }
    return nextRecord(bytes_);
  }

  /// False for the end of the data section.
  bool readDataRecord(const Record& record) {
    if (record.opcode == kDataEnd) {
      const auto crc = ByteReader(record.content).number<std::uint32_t>("a checksum");
      if (crc != 0 && crc != crcOf(all_.substr(0, record_begin_))) {
        throw Malformed("the checksum of the data is another, expected the same: the file is damaged");
      }
      return false;
    }
    if (record.opcode == 0 || record.opcode == kHeader || record.opcode == kFooter) {
      throw Malformed(fmt::format("found a record of kind {} inside the data, expected none there", record.opcode));
    }
    if (record.opcode == kChunk) {
      readChunk(ByteReader(record.content));
    } else {
      readPlain(record);  // indices, attachments and what is not known are passed over
    }
    return true;
  }

  void readPlain(const Record& record) {
    const ByteReader content(record.content);
    if (record.opcode == kSchema) readSchema(content);
    if (record.opcode == kChannel) readChannel(content);
    if (record.opcode == kMessage) readMessage(content);
  }

  void readChunk(ByteReader chunk) {
    chunk.take(2 * sizeof(std::uint64_t), "the times of a chunk");
    const auto size = chunk.number<std::uint64_t>("a chunk's size");
    const auto crc = chunk.number<std::uint32_t>("a chunk's checksum");
    const std::string_view compression = chunk.prefixed<std::uint32_t>("a chunk's compression");
    const std::string_view packed = chunk.prefixed<std::uint64_t>("a chunk");
    if (size > kLargestChunk) {
      throw Malformed(fmt::format("found a chunk of {} bytes, expected at most {}", size, kLargestChunk));
    }
    std::string unpacked;
    std::string_view records = packed;
    if (compression == "lz4") {
      records = unpacked = unpackLz4(packed, size);
    } else if (compression == "zstd") {
      records = unpacked = unpackZstd(packed, size);
    } else if (!compression.empty()) {
      throw Malformed(fmt::format("found a chunk packed with '{}', expected lz4 or zstd", abridged(compression)));
    }
    if (records.size() != size) {
      throw Malformed(fmt::format("found {} bytes in a chunk, expected the {} that it says", records.size(), size));
    }
    if (crc != 0 && crc != crcOf(records)) {
      throw Malformed("the checksum of a chunk is another, expected the same: the file is damaged");
    }
    for (ByteReader inside(records); inside.left() > 0;) {
      const Record record = nextRecord(inside);
      if (record.opcode == kChunk || record.opcode == kDataEnd) {
        throw Malformed(fmt::format("found a record of kind {} inside a chunk, expected messages", record.opcode));
      }
      readPlain(record);
    }
  }

  void readSchema(ByteReader schema) {
    const auto id = schema.number<std::uint16_t>("a schema");
    schema_names_[id] = shortType(schema.prefixed<std::uint32_t>("a schema's name"));
  }

  void readChannel(ByteReader channel) {
    const auto id = channel.number<std::uint16_t>("a channel");
    const auto schema = channel.number<std::uint16_t>("a channel's schema");
    BagTopic topic;
    topic.name = channel.prefixed<std::uint32_t>("a topic");
    topic.encoding = channel.prefixed<std::uint32_t>("an encoding");
    const auto type = schema_names_.find(schema);
    if (schema != 0 && type == schema_names_.end()) {
      throw Malformed(fmt::format("found no schema {} for the topic {}, expected it before the channel", schema,
                                  abridged(topic.name)));
    }
    if (schema != 0) topic.type = type->second;
    const auto [known, is_new] = channels_.try_emplace(id, topic);
    if (!is_new && (known->second.name != topic.name || known->second.encoding != topic.encoding)) {
      throw Malformed(fmt::format("found the channel {} twice, for {} and {}, expected one topic", id,
                                  abridged(known->second.name), abridged(topic.name)));
    }
  }

  void readMessage(ByteReader message) {
    const auto id = message.number<std::uint16_t>("a message");
    message.take(sizeof(std::uint32_t), "a message's number");
    const auto log_time = message.number<std::uint64_t>("a message's time");
    message.take(sizeof(std::uint64_t), "a message's time");
    const auto channel = channels_.find(id);
    if (channel == channels_.end()) {
      throw Malformed(fmt::format("found no channel {} for a message, expected it before the message", id));
    }
    if (log_time > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
      throw Malformed(fmt::format("found the time {} ns, expected one before the year 2262", log_time));
    }
    ++channel->second.messages;
    take_(channel->second, static_cast<std::int64_t>(log_time), message.take(message.left(), "a message"));
  }

  /// Behind the data stand a summary, which says nothing new, and the magic bytes once more.
  void requireEnd() {
    if (bytes_.left() < kMcapMagic.size() || !all_.ends_with(kMcapMagic)) {
      throw Malformed("found no end behind the recording, expected that of an MCAP: the file is cut short");
    }
  }

  ByteReader bytes_;
  std::string_view all_;
  const TakeMessage& take_;
  std::size_t record_begin_ = 0;
  std::map<std::uint16_t, std::string> schema_names_;
  std::map<std::uint16_t, BagTopic> channels_;
};

}  // namespace

std::vector<BagTopic> readMcap(std::string_view bytes, const std::string& file, const TakeMessage& take) {
  McapReader reader(bytes, take);
  try {
    return reader.read();
  } catch (const Malformed& error) {
    throw DataError(fmt::format("{}: byte {}: {}", file, reader.at(), error.what()));
  }
}

}  // namespace simgap::bags
