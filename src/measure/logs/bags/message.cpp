#include "message.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "byte_reader.h"
#include "simgap/core/run_directory.h"
#include "simgap/core/text.h"

namespace simgap::bags {
namespace {

constexpr std::string_view kJointState = "sensor_msgs/JointState";
constexpr std::array kPlainTypes = {std::string_view("std_msgs/Float64"), std::string_view("std_msgs/Float32"),
                                    std::string_view("std_msgs/Float64MultiArray"),
                                    std::string_view("std_msgs/Float32MultiArray")};
constexpr std::array kJointFields = {std::string_view("position"), std::string_view("velocity"),
                                     std::string_view("effort")};
constexpr std::uint32_t kMostNumbers = 1000;  // of one message: each is a column
constexpr std::int64_t kNanoseconds = 1'000'000'000;
constexpr int kDeepestMessage = 16;

/// Numbers of both serialisations of ROS: that of ROS 2 aligns each to its size and ends texts with a zero.
class RosReader {
 public:
  explicit RosReader(ByteReader bytes, bool cdr) : bytes_(bytes), cdr_(cdr) {}

  template <typename Number>
  Number number(std::string_view what) {
    if (cdr_) bytes_.align(sizeof(Number), what);
    return bytes_.number<Number>(what);
  }

  std::string_view text(std::string_view what) {
    const std::string_view all = bytes_.take(number<std::uint32_t>(what), what);
    if (!cdr_) return all;
    if (all.empty() || all.back() != '\0') throw Malformed(fmt::format("found no end of {}, expected a zero", what));
    return all.substr(0, all.size() - 1);
  }

  /// \throws Malformed: more than are worth reading
  std::uint32_t count(std::string_view what) {
    const auto count = number<std::uint32_t>(what);
    if (count > kMostNumbers) {
      throw Malformed(fmt::format("found {} numbers in {}, expected at most {}", count, what, kMostNumbers));
    }
    return count;
  }

  std::int64_t stamp() {
    if (!cdr_) number<std::uint32_t>("a header");
    const std::int64_t seconds = cdr_ ? number<std::int32_t>("a stamp") : number<std::uint32_t>("a stamp");
    const auto nanoseconds = number<std::uint32_t>("a stamp");
    text("a frame");
    return seconds * kNanoseconds + nanoseconds;
  }

  /// CDR messages may end with padding.
  void requireEnd() const {
    if (bytes_.left() > (cdr_ ? 3U : 0U)) {
      throw Malformed(fmt::format("found {} bytes behind the message, expected none", bytes_.left()));
    }
  }

 private:
  ByteReader bytes_;
  bool cdr_;
};

void requireAsManyAsNames(std::size_t numbers, std::size_t names, std::string_view field) {
  if (numbers == 0 || numbers == names) return;
  throw Malformed(fmt::format("found {} numbers in {} and {} names, expected as many", numbers, field, names));
}

void readJointState(RosReader& reader, Message& message) {
  message.stamp_ns = reader.stamp();
  std::vector<std::string_view> names;
  for (std::uint32_t left = reader.count("the names"); left > 0; --left) names.push_back(reader.text("a name"));
  for (const std::string_view field : kJointFields) {
    const std::uint32_t count = reader.count(field);
    requireAsManyAsNames(count, names.size(), field);
    for (std::uint32_t i = 0; i < count; ++i) {
      message.numbers.push_back({fmt::format("{}.{}", names[i], field), reader.number<double>(field)});
    }
  }
}

/// \param type  "std_msgs/Float32MultiArray"
void readPlain(std::string_view type, RosReader& reader, Message& message) {
  const bool is_double = type.starts_with("std_msgs/Float64");
  const auto next = [&] { return is_double ? reader.number<double>("data") : reader.number<float>("data"); };
  if (!type.ends_with("MultiArray")) {
    message.numbers.push_back({"", next()});
    return;
  }
  for (std::uint32_t left = reader.count("the dimensions"); left > 0; --left) {
    reader.text("a label");
    reader.number<std::uint32_t>("a dimension");
    reader.number<std::uint32_t>("a stride");
  }
  reader.number<std::uint32_t>("an offset");
  const std::uint32_t count = reader.count("data");
  for (std::uint32_t i = 0; i < count; ++i) message.numbers.push_back({std::to_string(i), next()});
}

/// CDR begins with two bytes for its kind and two for options (OMG DDSI-RTPS 2.5, 10.2).
RosReader cdrReader(std::string_view data) {
  ByteReader head(data);
  const auto zero = head.number<std::uint8_t>("a message"), kind = head.number<std::uint8_t>("a message");
  head.take(2, "a message");
  if (zero != 0 || kind > 1) {
    throw Malformed(
        fmt::format("found bytes {:02x} {:02x} at the beginning, expected 00 00 or 00 01, plain CDR "
                    "(28 b5: a recording with packed messages; `ros2 bag convert` unpacks them)",
                    zero, kind));
  }
  const auto order = kind == 1 ? std::endian::little : std::endian::big;
  return RosReader(ByteReader(data.substr(head.at()), order), /*cdr=*/true);
}

double numberOf(const Json& json, std::string_view what) {
  if (!json.is_number()) throw Malformed(fmt::format("found no number in {}, expected one", what));
  return json.get<double>();
}

/// {"header": {"stamp": {"sec": 1, "nanosec": 2}}}, with the words of ROS 1 or 2.
std::int64_t stampOf(const Json& message) {
  const Json stamp = message.value(Json::json_pointer("/header/stamp"), Json());
  const auto part = [&](std::initializer_list<const char*> keys) -> std::int64_t {
    for (const char* key : keys) {
      if (stamp.is_object() && stamp.contains(key) && stamp[key].is_number_integer()) {
        const auto value = stamp[key].get<double>();
        if (value >= 0.0 && value < 4294967296.0) return stamp[key].get<std::int64_t>();
      }
    }
    return 0;
  };
  return part({"sec", "secs"}) * kNanoseconds + part({"nanosec", "nsec", "nsecs"});
}

/// An array of at most so many entries.
const Json& arrayOf(const Json& json, std::string_view what) {
  if (!json.is_array()) throw Malformed(fmt::format("found no array in {}, expected one", what));
  if (json.size() > kMostNumbers) {
    throw Malformed(fmt::format("found {} numbers in {}, expected at most {}", json.size(), what, kMostNumbers));
  }
  return json;
}

void readJsonJoints(const Json& json, Message& message) {
  const Json& names = arrayOf(json["name"], "name");
  for (const std::string_view field : kJointFields) {
    if (!json.contains(field)) continue;
    const Json& numbers = arrayOf(json[std::string(field)], field);
    requireAsManyAsNames(numbers.size(), names.size(), field);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (!names[i].is_string()) throw Malformed("found no text in name, expected one");
      message.numbers.push_back(
          {fmt::format("{}.{}", names[i].get<std::string_view>(), field), numberOf(numbers[i], field)});
    }
  }
}

void readJsonMessage(std::string_view data, Message& message) {
  const auto refuseDepth = [](int depth, Json::parse_event_t, Json&) {
    if (depth > kDeepestMessage) throw Malformed("found JSON that is nested too deep, expected a message");
    return true;
  };
  const Json json = Json::parse(data, refuseDepth, /*allow_exceptions=*/false);
  if (!json.is_object()) throw Malformed("found no JSON object, expected one");
  message.stamp_ns = stampOf(json);
  if (json.contains("name")) {
    readJsonJoints(json, message);
  } else if (!json.contains("data")) {
    throw Malformed("found neither name nor data in the JSON, expected a JointState's or a float's keys");
  } else if (json["data"].is_array()) {
    const Json& numbers = arrayOf(json["data"], "data");
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      message.numbers.push_back({std::to_string(i), numberOf(numbers[i], "data")});
    }
  } else {
    message.numbers.push_back({"", numberOf(json["data"], "data")});
  }
}

bool isPlain(std::string_view type) { return std::ranges::find(kPlainTypes, type) != kPlainTypes.end(); }

}  // namespace

std::string shortType(std::string_view type) {
  const std::size_t middle = type.find("/msg/");
  if (middle == std::string_view::npos) return std::string(type);
  return fmt::format("{}/{}", type.substr(0, middle), type.substr(middle + 5));
}

bool isReadable(const BagTopic& topic) {
  if (topic.encoding == "json") return true;
  return (topic.encoding == "cdr" || topic.encoding == "ros1") && (topic.type == kJointState || isPlain(topic.type));
}

std::string readableTypes() {
  return fmt::format("{} or {} as cdr or ros1, or their JSON", kJointState, fmt::join(kPlainTypes, ", "));
}

void readMessage(const BagTopic& topic, std::string_view data, Message& message) {
  message.stamp_ns = 0;
  message.numbers.clear();
  if (topic.encoding == "json") return readJsonMessage(data, message);
  const bool cdr = topic.encoding == "cdr";
  RosReader reader = cdr ? cdrReader(data) : RosReader(ByteReader(data), /*cdr=*/false);
  if (topic.type == kJointState) {
    readJointState(reader, message);
  } else {
    readPlain(topic.type, reader, message);
  }
  reader.requireEnd();
}

}  // namespace simgap::bags
