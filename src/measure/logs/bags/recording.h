/// \file
/// One topic of a recording while it is read: what its messages hold of the numbers that were asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "message.h"

namespace simgap::bags {

/// Times and values, shape (n), of one column.
struct Series {
  std::string column;
  std::vector<std::int64_t> time;
  std::vector<double> value;
};

class Recording {
 public:
  explicit Recording(std::string topic) : topic_(std::move(topic)) {}

  const std::string& topic() const { return topic_; }
  void addField(std::string field) { fields_.push_back(std::move(field)); }

  /// \throws Malformed: a message that cannot be read, a number twice in one message, too many columns
  void take(const BagTopic& topic, std::int64_t time_ns, std::string_view data);

  std::size_t chosenColumns() const { return columns_.size(); }
  std::size_t messages() const { return log_times_.size(); }
  bool isStamped() const { return stamped_; }
  std::span<const std::string> fields() const { return fields_; }
  /// Every column that the topic has, chosen or not, and whether a field chooses it.
  const std::vector<std::string>& allColumns() const { return names_; }
  static bool fits(std::string_view column, std::string_view field);
  /// The chosen columns in the order in which they were first met, each with times that rise. What is held is given up.
  /// \param stamps  times of the headers, otherwise of the recorder
  std::vector<Series> series(bool stamps);

 private:
  struct Column {
    std::string name;
    std::vector<std::uint32_t> message;  ///< of the value
    std::vector<double> value;
  };
  std::size_t columnOf(const std::string& number);
  std::string columnName(const std::string& number) const;

  std::string topic_;
  std::vector<std::string> fields_;  ///< "" chooses all
  std::vector<std::int64_t> log_times_, stamps_;
  bool stamped_ = true;
  std::vector<Column> columns_;
  std::vector<std::string> names_;
  std::unordered_map<std::string, std::size_t> column_of_;  ///< of a number; kNotChosen
  Message message_;
};

}  // namespace simgap::bags
