#include <fmt/format.h>
#include <sqlite3.h>

#include <map>
#include <memory>
#include <new>

#include "bag_file.h"
#include "byte_reader.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/text.h"

namespace simgap::bags {
namespace {

constexpr int kLargestValue = 1 << 28;                  // [bytes] of one message
constexpr int kStepsUnasked = 10000;                    // of SQLite's machine between two looks for an interrupt
constexpr std::size_t kWriteVersion = 18;               // in the header of a SQLite file, then the version for reading
constexpr std::size_t kPageSize = 16, kPageCount = 28;  // there; 1 stands for the largest page
constexpr std::size_t kLargestPage = 1 << 16;
constexpr std::size_t kSmallestMessageRow = 4;  // [bytes] of the file: more rows than that are the same pages again
constexpr char kRollback = 1;                   // 2: write-ahead log, which a database in memory cannot have

/// SQLite reads what is missing of a page as zeros. \throws Malformed unless all pages of the header are there
void requireWhole(std::string_view bytes) {
  ByteReader header(bytes, std::endian::big);
  header.take(kPageSize, "a header");
  const auto said = header.number<std::uint16_t>("a header");
  const std::size_t page = said == 1 ? kLargestPage : said;
  header.take(kPageCount - header.at(), "a header");
  const std::size_t pages = header.number<std::uint32_t>("a header");
  if (page == 0 || bytes.size() % page != 0 || bytes.size() / page < pages) {
    throw Malformed(
        fmt::format("found {} bytes, expected {} pages of {}: the file is cut short", bytes.size(), pages, page));
  }
}

using Statement = std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)>;

/// A SQLite file in memory, read as the work of a stranger: no views, triggers, virtual tables or calculated columns.
class Database {
 public:
  explicit Database(std::string& bytes) : connection_(open(), &sqlite3_close) {
    sqlite3* const db = connection_.get();
    sqlite3_limit(db, SQLITE_LIMIT_LENGTH, kLargestValue);
    sqlite3_limit(db, SQLITE_LIMIT_ATTACHED, 0);
    for (const auto& [setting, value] : {std::pair{SQLITE_DBCONFIG_DEFENSIVE, 1},
                                         {SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0},
                                         {SQLITE_DBCONFIG_ENABLE_VIEW, 0},
                                         {SQLITE_DBCONFIG_ENABLE_TRIGGER, 0}}) {
      sqlite3_db_config(db, setting, value, nullptr);
    }
    sqlite3_progress_handler(
        db, kStepsUnasked, [](void*) { return interruptRequested() ? 1 : 0; }, nullptr);
    requireWhole(bytes);
    bytes[kWriteVersion] = bytes[kWriteVersion + 1] = kRollback;
    const auto size = static_cast<sqlite3_int64>(bytes.size());
    require(sqlite3_deserialize(db, "main", reinterpret_cast<unsigned char*>(bytes.data()), size, size,
                                SQLITE_DESERIALIZE_READONLY));
    require(sqlite3_exec(db, "PRAGMA cell_size_check=ON", nullptr, nullptr, nullptr));
  }

  Statement prepare(const std::string& sql) const {
    sqlite3_stmt* statement = nullptr;
    const int code = sqlite3_prepare_v2(connection_.get(), sql.c_str(), -1, &statement, nullptr);
    Statement owned(statement, &sqlite3_finalize);
    require(code);
    return owned;
  }

  /// False behind the last row.
  bool step(const Statement& statement) const {
    const int code = sqlite3_step(statement.get());
    if (code != SQLITE_ROW && code != SQLITE_DONE) require(code);
    return code == SQLITE_ROW;
  }

  /// \throws Malformed unless it is an ordinary table whose columns are all stored.
  void requireTable(const std::string& name) const {
    const Statement schema =
        prepare("SELECT 1 FROM sqlite_schema WHERE name = '" + name +
                "' AND type = 'table' AND rootpage > 0 AND NOT EXISTS (SELECT 1 FROM pragma_table_xinfo('" + name +
                "') WHERE hidden <> 0)");
    if (!step(schema)) throw Malformed(fmt::format("found no table {}, expected that of a rosbag2 recording", name));
  }

 private:
  static sqlite3* open() {
    sqlite3* connection = nullptr;
    const int code = sqlite3_open_v2(":memory:", &connection, SQLITE_OPEN_READWRITE | SQLITE_OPEN_MEMORY, nullptr);
    if (code == SQLITE_OK) return connection;
    sqlite3_close(connection);
    throw std::bad_alloc();
  }

  /// Also too little memory is the file's fault: a damaged length asks for more than SQLite would ever take.
  void require(int code) const {
    if (code == SQLITE_OK) return;
    stopIfInterrupted();
    throw Malformed(fmt::format("found no rosbag2 recording, expected one ({})", sqlite3_errmsg(connection_.get())));
  }

  std::unique_ptr<sqlite3, decltype(&sqlite3_close)> connection_;
};

std::string textOf(const Statement& row, int column, std::string_view what) {
  const bool is_text = sqlite3_column_type(row.get(), column) == SQLITE_TEXT;
  const auto* const text = is_text ? reinterpret_cast<const char*>(sqlite3_column_text(row.get(), column)) : nullptr;
  if (text == nullptr) throw Malformed(fmt::format("found no text for {} of a topic, expected one", what));
  return {text, static_cast<std::size_t>(sqlite3_column_bytes(row.get(), column))};
}

std::map<std::int64_t, BagTopic> readTopics(const Database& database) {
  database.requireTable("topics");
  std::map<std::int64_t, BagTopic> topics;
  const Statement row = database.prepare("SELECT id, name, type, serialization_format FROM topics");
  while (database.step(row)) {
    topics[sqlite3_column_int64(row.get(), 0)] = {textOf(row, 1, "the name"), shortType(textOf(row, 2, "the type")),
                                                  textOf(row, 3, "the encoding"), 0};
  }
  return topics;
}

/// \param most  rows that a file of its size can hold: damaged pages can be read again and again
void readMessages(const Database& database, std::size_t most, std::map<std::int64_t, BagTopic>& topics,
                  const TakeMessage& take) {
  database.requireTable("messages");
  const Statement row = database.prepare("SELECT topic_id, timestamp, data FROM messages");
  for (std::size_t count = 1; database.step(row); ++count) {
    if (count > most) throw Malformed("found more messages than the file has room for: it is damaged");
    const auto topic = topics.find(sqlite3_column_int64(row.get(), 0));
    if (topic == topics.end()) {
      throw Malformed(fmt::format("message {}: found no topic {}, expected one of the table topics", count,
                                  sqlite3_column_int64(row.get(), 0)));
    }
    const std::int64_t time = sqlite3_column_int64(row.get(), 1);
    if (sqlite3_column_type(row.get(), 1) != SQLITE_INTEGER || time < 0) {
      throw Malformed(fmt::format("message {}: found no timestamp, expected nanoseconds", count));
    }
    const auto* const data = static_cast<const char*>(sqlite3_column_blob(row.get(), 2));
    if (sqlite3_column_type(row.get(), 2) != SQLITE_BLOB) {
      throw Malformed(fmt::format("message {}: found no data, expected the bytes of a message", count));
    }
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(row.get(), 2));
    ++topic->second.messages;
    take(topic->second, time, data == nullptr ? std::string_view() : std::string_view(data, size));
  }
}

}  // namespace

std::vector<BagTopic> readRosbag2(std::string& bytes, const std::string& file, const TakeMessage& take) {
  try {
    const Database database(bytes);
    std::map<std::int64_t, BagTopic> by_id = readTopics(database);
    readMessages(database, bytes.size() / kSmallestMessageRow, by_id, take);
    std::vector<BagTopic> topics;
    for (auto& [id, topic] : by_id) topics.push_back(std::move(topic));
    return topics;
  } catch (const Malformed& error) {
    throw DataError(fmt::format("{}: {}", file, error.what()));
  }
}

}  // namespace simgap::bags
