#include "recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "byte_reader.h"
#include "simgap/core/text.h"

namespace simgap::bags {
namespace {

constexpr std::size_t kNotChosen = std::numeric_limits<std::size_t>::max();
constexpr std::size_t kMostColumns = 3000;  // of a topic: three per number of a message

}  // namespace

bool Recording::fits(std::string_view column, std::string_view field) {
  return field.empty() || column == field || column.starts_with(fmt::format("{}.", field)) ||
         column.ends_with(fmt::format(".{}", field));
}

/// "elbow.position"; "motor/current" and "motor/currents.3" of /motor/current and /motor/currents.
std::string Recording::columnName(const std::string& number) const {
  if (number.find('.') != std::string::npos) return number;
  const std::string topic = topic_.starts_with('/') ? topic_.substr(1) : topic_;
  return number.empty() ? topic : fmt::format("{}.{}", topic, number);
}

std::size_t Recording::columnOf(const std::string& number) {
  const auto [found, is_new] = column_of_.try_emplace(number, kNotChosen);
  if (!is_new) return found->second;
  if (names_.size() == kMostColumns) {
    throw Malformed(fmt::format("found more than {} different numbers, expected at most as many", kMostColumns));
  }
  const std::string& name = names_.emplace_back(columnName(number));
  if (name.find(';') != std::string::npos || printable(name) != name) {
    throw Malformed(fmt::format("found the name {}, expected none with semicolons or control characters",
                                abridged(printable(name))));
  }
  if (std::ranges::any_of(fields_, [&](const std::string& field) { return fits(name, field); })) {
    found->second = columns_.size();
    columns_.push_back({name, {}, {}});
  }
  return found->second;
}

void Recording::take(const BagTopic& topic, std::int64_t time_ns, std::string_view data) {
  readMessage(topic, data, message_);
  const auto index = static_cast<std::uint32_t>(log_times_.size());
  log_times_.push_back(time_ns);
  stamps_.push_back(message_.stamp_ns);
  stamped_ = stamped_ && message_.stamp_ns > 0;
  for (const NamedNumber& number : message_.numbers) {
    const std::size_t at = columnOf(number.name);
    if (at == kNotChosen) continue;
    Column& column = columns_[at];
    if (!column.message.empty() && column.message.back() == index) {
      throw Malformed(fmt::format("found {} twice, expected it once", abridged(column.name)));
    }
    column.message.push_back(index);
    column.value.push_back(number.value);
  }
}

std::vector<Series> Recording::series(bool stamps) {
  const std::vector<std::int64_t>& times = stamps ? stamps_ : log_times_;
  std::vector<Series> all;
  for (Column& column : columns_) {
    std::vector<std::uint32_t> order(column.message.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto timeOf = [&](std::uint32_t i) { return times[column.message[i]]; };
    std::ranges::stable_sort(order, {}, timeOf);
    Series& series = all.emplace_back();
    series.column = std::move(column.name);
    for (const std::uint32_t i : order) {
      series.time.push_back(timeOf(i));
      series.value.push_back(column.value[i]);
    }
    column = {};
  }
  return all;
}

}  // namespace simgap::bags
