// Recordings in every dress, written by a writer of the tests' own, and recordings that lie about themselves.
#include "simgap/measure/logs/bag.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/bags.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pointwise;
using ::testing::StartsWith;

using Topics = std::vector<std::string>;

BagLog recorded(const std::string& bytes, const Topics& topics) { return readBag(bytes, "run.bag", topics); }

std::vector<double> column(const BagLog& log, const std::string& name) { return log.table.quantity(name, ""); }

std::string bagRefusal(const std::string& bytes, const Topics& topics = {"/joint_states"}) {
  return errorOf([&] { recorded(bytes, topics); });
}

void expectSmallRecording(const std::string& bytes) {
  const BagLog log = recorded(bytes, {"/joint_states"});
  EXPECT_THAT(log.table.columns(),
              ElementsAre("time_s", "shoulder.position", "elbow.position", "shoulder.velocity", "elbow.velocity"));
  EXPECT_THAT(log.table.quantity("time", "s"), Pointwise(DoubleNear(1e-12), {0.0, 0.01, 0.02, 0.03, 0.04, 0.05}));
  EXPECT_EQ(column(log, "elbow.position"), (std::vector<double>{0.0, -0.5, -1.0, -1.5, -2.0, -2.5}));
  EXPECT_EQ(column(log, "elbow.velocity"), (std::vector<double>{2.0, 3.0, 4.0, 5.0, 6.0, 7.0}));
  EXPECT_THAT(log.notes, IsEmpty());
}

TEST(Bag, IsKnownByItsFirstBytes) {
  EXPECT_TRUE(isBag(mcapBytes(smallRecording())));
  EXPECT_TRUE(isBag(rosbag2Bytes(smallRecording())));
  EXPECT_FALSE(isBag("time_s,motor_current_A\n"));
  EXPECT_FALSE(isBag(""));
}

TEST(Bag, ReadsEveryDressOfMcap) {
  for (const char* compression : {"zstd", "lz4", "", "no chunks"}) {
    for (const bool checksums : {true, false}) {
      SCOPED_TRACE(compression);
      expectSmallRecording(mcapBytes(smallRecording(), {.compression = compression, .checksums = checksums}));
    }
  }
}

TEST(Bag, ReadsBothByteOrdersAndRos1) {
  for (const Wire wire : {Wire::kCdrLittle, Wire::kCdrBig, Wire::kRos1}) {
    expectSmallRecording(mcapBytes(smallRecording(wire)));
  }
}

TEST(Bag, ReadsRosbag2) {
  expectSmallRecording(rosbag2Bytes(smallRecording()));
  std::string with_log = rosbag2Bytes(smallRecording());  // as a recorder with a write-ahead log leaves it
  with_log[18] = with_log[19] = 2;
  expectSmallRecording(with_log);
}

TEST(Bag, ReadsJson) {
  std::vector<RecordedMessage> messages;
  for (int i = 0; i < 3; ++i) {
    messages.push_back({"/joints", "", "json", 1000 + i,
                        R"({"header": {"stamp": {"sec": 5, "nsec": )" + std::to_string(500000000 * i) +
                            R"(}}, "name": ["a"], "position": [)" + std::to_string(i) + R"(.5], "effort": [7]})"});
  }
  const BagLog log = recorded(mcapBytes(messages), {"/joints"});
  EXPECT_THAT(log.table.columns(), ElementsAre("time_s", "a.position", "a.effort"));
  EXPECT_THAT(log.table.quantity("time", "s"), ElementsAre(0.0, 0.5, 1.0));
  EXPECT_THAT(column(log, "a.position"), ElementsAre(0.5, 1.5, 2.5));
  const BagLog plain = recorded(mcapBytes({{"/f", "", "json", 5, R"({"data": [1, 2.5]})"}}), {"/f"});
  EXPECT_THAT(plain.table.columns(), ElementsAre("time_s", "f.0", "f.1"));
  EXPECT_THAT(bagRefusal(mcapBytes({{"/f", "", "json", 5, R"({"value": 1})"}}), {"/f"}),
              HasSubstr("/f: message 1: found neither name nor data"));
}

TEST(Bag, ReadsPlainFloatsAndArrays) {
  const std::vector<RecordedMessage> messages = {
      {"/f32", "std_msgs/msg/Float32", "cdr", 10, float32(Wire::kCdrLittle, 0.5F)},
      {"/many", "std_msgs/msg/Float64MultiArray", "cdr", 10, float64Array(Wire::kCdrLittle, {1.5, -2.0, 3.0})},
      {"/old", "std_msgs/Float64MultiArray", "ros1", 10, float64Array(Wire::kRos1, {4.0})}};
  const BagLog log = recorded(mcapBytes(messages), {"/f32", "/many:2", "/many:0", "/old"});
  EXPECT_THAT(log.table.columns(), ElementsAre("time_s", "f32", "many.0", "many.2", "old.0"));
  EXPECT_EQ(column(log, "f32"), std::vector<double>{0.5});
  EXPECT_EQ(column(log, "many.2"), std::vector<double>{3.0});
  EXPECT_EQ(column(log, "old.0"), std::vector<double>{4.0});
}

TEST(Bag, InterpolatesOtherTopicsAtTheFirstOnesTimes) {
  // Floats have no header: all times are the recorder's. They come 5 ms after the joints.
  const BagLog log = recorded(mcapBytes(smallRecording()), {"/joint_states:elbow.velocity", "/motor/current"});
  EXPECT_THAT(log.table.columns(), ElementsAre("time_s", "elbow.velocity", "motor/current"));
  EXPECT_EQ(column(log, "elbow.velocity"), (std::vector<double>{3.0, 4.0, 5.0, 6.0, 7.0}));
  EXPECT_THAT(column(log, "motor/current"), Pointwise(DoubleNear(1e-12), {10.5, 11.5, 12.5, 13.5, 14.5}));
  EXPECT_THAT(log.notes, ElementsAre("run.bag: 1 of 6 messages of /joint_states left out, at times that other columns "
                                     "do not have"));
}

TEST(Bag, LeavesAGapOpen) {
  std::vector<RecordedMessage> messages;
  for (int i = 0; i <= 40; ++i) {
    messages.push_back({"/a", "std_msgs/msg/Float64", "cdr", 10 * i, float64(Wire::kCdrLittle, i)});
    if (i < 10 || i > 25) {
      messages.push_back({"/b", "std_msgs/msg/Float64", "cdr", 10 * i, float64(Wire::kCdrLittle, 2.0 * i)});
    }
  }
  const BagLog log = recorded(mcapBytes(messages), {"/a", "/b"});
  EXPECT_EQ(log.table.rows(), 41u);
  EXPECT_THAT(log.table.badRows("b"), ElementsAre(10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25));
}

TEST(Bag, NamesColumnsOfTwoTopicsApart) {
  std::vector<RecordedMessage> messages = smallRecording();
  messages.push_back({"/other", "sensor_msgs/msg/JointState", "cdr", messages[0].time_ns, messages[0].data});
  messages.push_back({"/other", "sensor_msgs/msg/JointState", "cdr", messages[10].time_ns, messages[10].data});
  const BagLog log = recorded(mcapBytes(messages), {"/joint_states:elbow.position", "/other:elbow.position"});
  EXPECT_THAT(log.table.columns(), ElementsAre("time_s", "/joint_states:elbow.position", "/other:elbow.position"));
}

TEST(Bag, SortsWhatStandsInAnotherOrderInTheFile) {
  std::vector<RecordedMessage> messages = smallRecording();
  std::swap(messages[0], messages[8]);
  expectSmallRecording(mcapBytes(messages));
}

TEST(Bag, TakesMapsAsAnyTable) {
  CsvOptions options;
  options.rename["motor_current_A"] = "motor/current";
  options.scale["motor_current_A"] = -0.001;
  const BagLog log = readBag(mcapBytes(smallRecording()), "run.bag", Topics{"/motor/current"}, options);
  EXPECT_THAT(log.table.quantity("motor_current", "A"),
              Pointwise(DoubleNear(1e-15), {-0.010, -0.011, -0.012, -0.013, -0.014, -0.015}));
}

TEST(Bag, SaysWhichTopicsThereAre) {
  const std::string bag = rosbag2Bytes(smallRecording());
  EXPECT_EQ(
      bagRefusal(bag, {"/joint_state"}),
      "3: run.bag: found no topic /joint_state, expected one of /joint_states (sensor_msgs/JointState, 6 messages), "
      "/motor/current (std_msgs/Float64, 6 messages); did you mean /joint_states?");
  EXPECT_THAT(bagRefusal(bag, {}),
              StartsWith("2: run.bag: found a recording and no --topic, expected at least one of "));
  EXPECT_EQ(
      bagRefusal(bag, {"/joint_states:elbo"}),
      "3: run.bag: /joint_states: found nothing called elbo, expected it among shoulder.position, elbow.position, "
      "shoulder.velocity, elbow.velocity");
}

TEST(Bag, SaysWhatItCannotRead) {
  const auto typed = [](const std::string& type, const std::string& encoding) {
    return bagRefusal(mcapBytes({{"/t", type, encoding, 1, std::string(8, '\0')}}), {"/t"});
  };
  EXPECT_THAT(typed("sensor_msgs/msg/Image", "cdr"),
              StartsWith("3: run.bag: /t: found sensor_msgs/Image as cdr, expected "));
  EXPECT_THAT(typed("std_msgs/msg/Float64", "protobuf"),
              StartsWith("3: run.bag: /t: found std_msgs/Float64 as protobuf"));
  EXPECT_THAT(typed("std_msgs/msg/Float64", "cdr"), HasSubstr("/t: message 1: found 4 bytes for data, expected 8"));
}

TEST(Bag, RefusesTopicsOfDifferentTimes) {
  const std::vector<RecordedMessage> messages = {
      {"/a", "std_msgs/msg/Float64", "cdr", 10, float64(Wire::kCdrLittle, 1.0)},
      {"/b", "std_msgs/msg/Float64", "cdr", 20, float64(Wire::kCdrLittle, 1.0)}};
  EXPECT_EQ(bagRefusal(mcapBytes(messages), {"/a", "/b"}),
            "3: run.bag: b begins when a has ended, expected columns of the same time");
}

TEST(Bag, RefusesAnUnfinishedRecording) {
  EXPECT_THAT(bagRefusal(mcapBytes(smallRecording(), {.closed = false})),
              HasSubstr("the recorder was stopped before it had closed the file"));
  const std::string whole = mcapBytes(smallRecording());
  EXPECT_THAT(bagRefusal(whole.substr(0, whole.size() - 3)), HasSubstr("the file is cut short"));
}

TEST(Bag, RefusesEveryCut) {
  for (const std::string& whole :
       {mcapBytes(smallRecording()), mcapBytes(smallRecording(), {.compression = "no chunks"}),
        rosbag2Bytes(smallRecording())}) {
    for (std::size_t size = 16; size < whole.size(); size += 7) {
      EXPECT_THAT(bagRefusal(whole.substr(0, size)), StartsWith("3: run.bag: ")) << size << " of " << whole.size();
    }
  }
}

TEST(Bag, RefusesADatabaseWithoutItsLastPages) {
  const std::string whole = rosbag2Bytes(smallRecording());
  for (std::size_t size = 512; size < whole.size(); size += 512) {
    EXPECT_THAT(bagRefusal(whole.substr(0, size)), HasSubstr("the file is cut short")) << size;
  }
}

TEST(Bag, RefusesAWrongChecksum) {
  std::string chunked = mcapBytes(smallRecording(), {.compression = ""});
  chunked[chunked.find("shoulder")] = 'S';
  EXPECT_THAT(bagRefusal(chunked), HasSubstr("the checksum of a chunk is another"));
  std::string plain = mcapBytes(smallRecording(), {.compression = "no chunks"});
  plain[plain.find("shoulder")] = 'S';
  EXPECT_THAT(bagRefusal(plain), HasSubstr("the checksum of the data is another"));
}

TEST(Bag, RefusesAbsurdLengths) {
  const std::string zeros(1 << 20, '\0');
  EXPECT_THAT(bagRefusal(mcapAround(mcapChunk("zstd", ~std::uint64_t{0}, 0, zstdPacked(zeros)))),
              HasSubstr("found a chunk of 18446744073709551615 bytes, expected at most 1073741824"));
  EXPECT_THAT(bagRefusal(mcapAround(mcapChunk("zstd", 1000, 0, zstdPacked(zeros)))),
              HasSubstr("found more than the 1000 bytes that the chunk says"));
  EXPECT_THAT(bagRefusal(mcapAround(mcapChunk("lz4", zeros.size() + 1, 0, lz4Packed(zeros)))),
              HasSubstr("found 1048576 bytes in a chunk, expected the 1048577 that it says"));
  EXPECT_THAT(bagRefusal(mcapAround(mcapChunk("lz4", 1000, 0, "nothing of the kind"))),
              HasSubstr("a damaged lz4 chunk"));
  EXPECT_THAT(bagRefusal(mcapAround(mcapChunk("brotli", 3, 0, "abc"))),
              HasSubstr("packed with 'brotli', expected lz4 or zstd"));
  std::string record = mcapRecord(0x05, "message");
  record[8] = '\x7f';  // the highest byte of its length
  EXPECT_THAT(bagRefusal(mcapAround(record)), HasSubstr("bytes for a record, expected 9151314442816847879"));
}

TEST(Bag, RefusesMessagesThatLieAboutTheirSize) {
  std::string names = jointState(Wire::kCdrLittle, 5, {"a"}, {1.0}, {}, {});
  names[names.find("base") + 8] = '\x7f';  // the count of the names, behind the frame's end and padding
  const auto message = [](const std::string& data) {
    return mcapBytes({{"/joint_states", "sensor_msgs/msg/JointState", "cdr", 1, data}});
  };
  EXPECT_THAT(bagRefusal(message(names)), HasSubstr("/joint_states: message 1: "));
  EXPECT_THAT(bagRefusal(message(jointState(Wire::kCdrLittle, 5, {"a"}, {1.0, 2.0}, {}, {}))),
              HasSubstr("found 2 numbers in position and 1 names, expected as many"));
  EXPECT_THAT(bagRefusal(message(jointState(Wire::kCdrLittle, 5, {"a", "a"}, {1.0, 2.0}, {}, {}))),
              HasSubstr("found a.position twice"));
  EXPECT_THAT(bagRefusal(message(jointState(Wire::kCdrLittle, 5, {"a;b"}, {1.0}, {}, {}))),
              HasSubstr("expected none with semicolons"));
  EXPECT_THAT(bagRefusal(message(jointState(Wire::kCdrLittle, 5, {"a"}, {1.0}, {}, {}) + "12345678")),
              HasSubstr("found 8 bytes behind the message"));
  EXPECT_THAT(bagRefusal(message(zstdPacked("a packed message"))), HasSubstr("found bytes 28 b5 at the beginning"));
}

TEST(Bag, RefusesTablesThatAreNone) {
  const std::string topics = "CREATE TABLE topics(id, name, type, serialization_format, offered_qos_profiles);";
  EXPECT_THAT(bagRefusal(rosbag2Bytes({}, topics + "CREATE VIEW messages AS SELECT 1 AS topic_id, 2 AS timestamp, "
                                                   "zeroblob(100000000) AS data;")),
              HasSubstr("found no table messages, expected that of a rosbag2 recording"));
  EXPECT_THAT(bagRefusal(rosbag2Bytes({}, topics + "CREATE TABLE messages(topic_id, timestamp, data AS "
                                                   "(zeroblob(100000000)));")),
              HasSubstr("found no table messages"));
  EXPECT_THAT(bagRefusal(rosbag2Bytes({}, "CREATE TABLE other(id);")), HasSubstr("found no table topics"));
}

}  // namespace
}  // namespace simgap::test
