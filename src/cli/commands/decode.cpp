#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "simgap/cli/command.h"
#include "simgap/cli/session.h"
#include "simgap/core/error.h"
#include "simgap/decode/edf.h"
#include "simgap/report/decode/decode_report.h"

namespace simgap::commands::decode {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  std::string action;
  std::vector<std::filesystem::path> files;
  EegLabels labels;
  TrainingOptions training;
  std::optional<double> threshold;
};

EegRecording readRecording(const Options& options, Session& session) {
  const Input& input = session.read("recording", options.files.back());
  EegRecording recording =
      isEdf(input.content)
          ? readEdf(input.content, input.file.string(), options.labels)
          : readEeg(CsvTable::parse(input.content, input.file.string(), options.table.csv()), options.labels);
  for (const std::string& sentence : checkEeg(recording)) spdlog::warn("{}", sentence);
  return recording;
}

Training learn(const Options& options, const EegRecording& recording) {
  constexpr std::size_t kSteps = 100;
  Progress progress("decode: train", kSteps, options.common.quiet, Progress::Unit::kPercent);
  Training training = trainDecoder(recording, options.training, [&](double done, const char* what) {
    progress.update(static_cast<std::size_t>(kSteps * done), what);
  });
  progress.update(kSteps);
  return training;
}

ExitCode train(const Options& options, Session& session) {
  if (options.files.size() != 1) throw ConfigError("decode train needs one file, RECORDING");
  const EegRecording recording = readRecording(options, session);
  if (options.common.dry_run) {
    session.print(fmt::format("would learn from {} channels of {}; nothing was written\n", recording.channels.size(),
                              recording.name));
    return ExitCode::kDone;
  }
  const Training training = learn(options, recording);
  session.begin(options.common.seed.value_or(0));
  if (training.betterThanChance()) {  // what is no better is not delivered
    session.directory().write("decoder.yaml", toYaml(training.decoder));
    session.directory().write("patterns.csv", patternsCsv(training.decoder));
  }
  const Json result = toJson(training, recording);
  session.finish(result, decodeTrainText(result));
  return training.betterThanChance() ? ExitCode::kDone : ExitCode::kCriterionFailed;
}

ExitCode run(const Options& options, Session& session) {
  if (options.files.size() != 2) throw ConfigError("decode run needs two files, DECODER and RECORDING");
  const Input& input = session.read("model", options.files.front());
  Decoder decoder = readDecoder(YamlNode::parse(input.content, input.file.string()));
  decoder.settings.threshold = options.threshold.value_or(decoder.settings.threshold);
  const EegRecording recording = readRecording(options, session);
  const Decoded decoded = simgap::decode(decoder, recording);
  const Json result = toJson(decoded, recording);
  if (options.common.dry_run) {
    session.print(fmt::format("would decode {} samples; nothing was written\n", decoded.times.size()));
    return ExitCode::kDone;
  }
  session.begin(options.common.seed.value_or(0));
  session.directory().write("decoded.csv", decodedCsv(decoded));
  session.finish(result, decodeRunText(result));
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  DecoderSettings& settings = options->training.settings;
  app.add_option("ACTION", options->action, "train, or run")->required()->check(CLI::IsMember({"train", "run"}));
  app.add_option("FILES", options->files,
                 "train: RECORDING (CSV: time_s, eeg_<channel>_uV, label; or EDF, BDF); run: DECODER (YAML), RECORDING")
      ->required()
      ->expected(1, 2);
  app.add_option("--up", options->labels.up, "the label that means up");
  app.add_option("--down", options->labels.down, "the label that means down");
  app.add_option("--low", settings.low, "lower end of the band [Hz]")->check(positiveNumber());
  app.add_option("--high", settings.high, "upper end [Hz]")->check(positiveNumber());
  app.add_option("--window-s", settings.window, "length of a covariance's window [s]")->check(CLI::Range(0.1, 60.0));
  app.add_option("--threshold", options->threshold,
                 "probability at which the state switches (run: instead of the decoder's)")
      ->check(CLI::Range(0.5, 1.0));
  app.add_option("--folds", options->training.folds, "parts that are held out in turn")->check(CLI::Range(2, 20));
  options->table.add(app);
  options->common.add(app);
  return [options, argv, &app] {
    DecoderSettings& s = options->training.settings;
    s.threshold = options->threshold.value_or(s.threshold);
    if (options->action == "run") {
      refuseOptions(app, {"--low", "--high", "--window-s", "--folds"},
                    "with decode run, expected it with train: a decoder has its own");
    }
    if (s.high <= s.low) throw ConfigError(fmt::format("found --low {:g} --high {:g}, expected a band", s.low, s.high));
    Session session("decode", options->common, argv);
    return options->action == "train" ? train(*options, session) : run(*options, session);
  };
}

}  // namespace

extern const Command entry;
const Command entry{"decode", "which of two states a head has in mind, from its EEG",
                    "  simgap decode train data/eeg/imagery.csv.gz -o runs/decoder\n"
                    "  simgap decode run runs/decoder/decoder.yaml \\\n"
                    "    data/eeg/imagery-later.csv.gz -o runs/decoded",
                    define};

}  // namespace simgap::commands::decode
