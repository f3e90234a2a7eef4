#include "support/bags.h"

#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <bit>
#include <map>
#include <stdexcept>

namespace simgap::test {
namespace {

/// Bytes of a number, the last first where it is big-endian.
template <typename Number>
std::string raw(Number value, bool big = false) {
  std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
  if (big == (std::endian::native == std::endian::little)) std::ranges::reverse(bytes);
  return bytes;
}

/// One message, number by number.
class Writer {
 public:
  explicit Writer(Wire wire) : wire_(wire) {
    if (wire != Wire::kRos1)
      head_ = std::string("\0", 1) + (wire == Wire::kCdrBig ? '\0' : '\1') + std::string(2, '\0');
  }
  template <typename Number>
  void put(Number value) {
    while (wire_ != Wire::kRos1 && body_.size() % sizeof value != 0) body_ += '\0';
    body_ += raw(value, wire_ == Wire::kCdrBig);
  }
  void text(std::string text) {
    if (wire_ != Wire::kRos1) text += '\0';
    put(static_cast<std::uint32_t>(text.size()));
    body_ += text;
  }
  void numbers(const std::vector<double>& values) {
    put(static_cast<std::uint32_t>(values.size()));
    for (const double value : values) put(value);
  }
  std::string bytes() const { return head_ + body_; }

 private:
  Wire wire_;
  std::string head_, body_;
};

std::string prefixed(std::string_view text) { return raw(static_cast<std::uint32_t>(text.size())) + std::string(text); }

std::uint32_t crc(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

std::string messageRecord(std::uint16_t channel, std::uint32_t number, const RecordedMessage& message) {
  const auto time = raw(static_cast<std::uint64_t>(message.time_ns));
  return mcapRecord(0x05, raw(channel) + raw(number) + time + time + message.data);
}

std::string chunkOf(const std::string& records, const McapStyle& style) {
  if (style.compression == "no chunks") return records;
  std::string packed = records;
  if (style.compression == "lz4") packed = lz4Packed(records);
  if (style.compression == "zstd") packed = zstdPacked(records);
  return mcapChunk(style.compression, records.size(), style.checksums ? crc(records) : 0, packed);
}

void check(int code, sqlite3* database) {
  if (code != SQLITE_OK && code != SQLITE_DONE) throw std::runtime_error(sqlite3_errmsg(database));
}

}  // namespace

std::string jointState(Wire wire, std::int64_t stamp_ns, const std::vector<std::string>& names,
                       const std::vector<double>& position, const std::vector<double>& velocity,
                       const std::vector<double>& effort) {
  Writer writer(wire);
  if (wire == Wire::kRos1) writer.put(std::uint32_t{7});  // the header's number
  writer.put(static_cast<std::int32_t>(stamp_ns / 1'000'000'000));
  writer.put(static_cast<std::uint32_t>(stamp_ns % 1'000'000'000));
  writer.text("base");
  writer.put(static_cast<std::uint32_t>(names.size()));
  for (const std::string& name : names) writer.text(name);
  writer.numbers(position);
  writer.numbers(velocity);
  writer.numbers(effort);
  return writer.bytes();
}

std::string float64(Wire wire, double value) {
  Writer writer(wire);
  writer.put(value);
  return writer.bytes();
}

std::string float32(Wire wire, float value) {
  Writer writer(wire);
  writer.put(value);
  return writer.bytes();
}

std::string float64Array(Wire wire, const std::vector<double>& values) {
  Writer writer(wire);
  writer.put(std::uint32_t{1});  // dimensions
  writer.text("motor");
  writer.put(static_cast<std::uint32_t>(values.size()));
  writer.put(static_cast<std::uint32_t>(values.size()));
  writer.put(std::uint32_t{0});  // offset
  writer.numbers(values);
  return writer.bytes();
}

std::string mcapRecord(std::uint8_t kind, std::string_view content) {
  return raw(kind) + raw(static_cast<std::uint64_t>(content.size())) + std::string(content);
}

std::string mcapChunk(std::string_view compression, std::uint64_t size, std::uint32_t checksum,
                      std::string_view packed) {
  return mcapRecord(0x06, raw(std::uint64_t{0}) + raw(std::uint64_t{0}) + raw(size) + raw(checksum) +
                              prefixed(compression) + raw(static_cast<std::uint64_t>(packed.size())) +
                              std::string(packed));
}

std::string mcapAround(std::string_view records, bool checksum) {
  const std::string magic = "\x89MCAP0\r\n";
  const std::string data = magic + mcapRecord(0x01, prefixed("ros2") + prefixed("a test")) + std::string(records);
  return data + mcapRecord(0x0F, raw(checksum ? crc(data) : 0U)) +
         mcapRecord(0x02, raw(std::uint64_t{0}) + raw(std::uint64_t{0}) + raw(std::uint32_t{0})) + magic;
}

std::string mcapBytes(const std::vector<RecordedMessage>& messages, const McapStyle& style) {
  std::map<std::string, std::uint16_t> channels;
  std::string all, chunk;
  std::uint32_t number = 0;
  for (const RecordedMessage& message : messages) {
    const auto next = static_cast<std::uint16_t>(channels.size() + 1);
    const auto [channel, is_new] = channels.try_emplace(message.topic, next);
    if (is_new) {
      const bool typed = !message.type.empty();
      if (typed)
        chunk += mcapRecord(0x03, raw(next) + prefixed(message.type) + prefixed("ros2msg") + prefixed("float64 data"));
      chunk += mcapRecord(0x04, raw(next) + raw(typed ? next : std::uint16_t{0}) + prefixed(message.topic) +
                                    prefixed(message.encoding) + raw(std::uint32_t{0}));
    }
    chunk += messageRecord(channel->second, number++, message);
    if (number % style.messages_per_chunk == 0) {
      all += chunkOf(chunk, style) + mcapRecord(0x07, "an index");
      chunk.clear();
    }
  }
  if (!chunk.empty()) all += chunkOf(chunk, style);
  const std::string whole = mcapAround(all, style.checksums);
  const std::size_t behind = 2 * 9 + 4 + 20 + 8;  // the end of the data, the footer, the magic bytes
  return style.closed ? whole : whole.substr(0, whole.size() - behind);
}

std::string lz4Packed(std::string_view bytes) {
  std::string packed(LZ4F_compressFrameBound(bytes.size(), nullptr), '\0');
  packed.resize(LZ4F_compressFrame(packed.data(), packed.size(), bytes.data(), bytes.size(), nullptr));
  return packed;
}

std::string zstdPacked(std::string_view bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 19));
  return packed;
}

std::string rosbag2Bytes(const std::vector<RecordedMessage>& messages, const std::string& sql) {
  sqlite3* database = nullptr;
  check(sqlite3_open(":memory:", &database), database);
  const std::string tables =
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT "
      "NOT NULL, offered_qos_profiles TEXT NOT NULL);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB "
      "NOT NULL); CREATE INDEX timestamp_idx ON messages (timestamp ASC);";
  check(sqlite3_exec(database, ("PRAGMA page_size=512;" + (sql.empty() ? tables : sql)).c_str(), nullptr, nullptr,
                     nullptr),
        database);
  std::map<std::string, int> ids;
  const auto insert = [&](const char* text, const auto& bind) {
    sqlite3_stmt* statement = nullptr;
    check(sqlite3_prepare_v2(database, text, -1, &statement, nullptr), database);
    bind(statement);
    check(sqlite3_step(statement), database);
    sqlite3_finalize(statement);
  };
  for (const RecordedMessage& message : messages) {
    const auto [id, is_new] = ids.try_emplace(message.topic, static_cast<int>(ids.size() + 1));
    if (is_new) {
      insert("INSERT INTO topics(id, name, type, serialization_format, offered_qos_profiles) VALUES(?, ?, ?, ?, '')",
             [&, topic = id->second](sqlite3_stmt* row) {
               sqlite3_bind_int(row, 1, topic);
               sqlite3_bind_text(row, 2, message.topic.c_str(), -1, SQLITE_STATIC);
               sqlite3_bind_text(row, 3, message.type.c_str(), -1, SQLITE_STATIC);
               sqlite3_bind_text(row, 4, message.encoding.c_str(), -1, SQLITE_STATIC);
             });
    }
    insert("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)",
           [&, topic = id->second](sqlite3_stmt* row) {
             sqlite3_bind_int(row, 1, topic);
             sqlite3_bind_int64(row, 2, message.time_ns);
             sqlite3_bind_blob(row, 3, message.data.data(), static_cast<int>(message.data.size()), SQLITE_STATIC);
           });
  }
  sqlite3_int64 size = 0;
  unsigned char* const bytes = sqlite3_serialize(database, "main", &size, 0);
  std::string result(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(size));
  sqlite3_free(bytes);
  sqlite3_close(database);
  return result;
}

std::vector<RecordedMessage> smallRecording(Wire wire) {
  const std::string encoding = wire == Wire::kRos1 ? "ros1" : "cdr", middle = wire == Wire::kRos1 ? "/" : "/msg/";
  std::vector<RecordedMessage> messages;
  for (int i = 0; i < 6; ++i) {
    const std::int64_t time = 1'700'000'000'000'000'000 + i * 10'000'000;
    messages.push_back(
        {"/joint_states", "sensor_msgs" + middle + "JointState", encoding, time,
         jointState(wire, time - 1'000'000, {"shoulder", "elbow"}, {0.1 * i, -0.5 * i}, {1.0, 2.0 + i}, {})});
    messages.push_back(
        {"/motor/current", "std_msgs" + middle + "Float64", encoding, time + 5'000'000, float64(wire, 10.0 + i)});
  }
  return messages;
}

}  // namespace simgap::test
