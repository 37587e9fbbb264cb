/// \file
/// The material history as a folder with `history.json`: what the file says, a reader and a writer.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "patinate/history/history_value.h"
#include "patinate/image/image.h"

namespace patinate {

/// ControlFacts with its file.
struct ControlParameter {
  std::string name;
  std::filesystem::path file;  ///< Relative to the history; float.
  double low = 0.0;            ///< Physical value that 0 stands for.
  double high = 1.0;           ///< Physical value that 1 stands for.
  std::string unit = "";       ///< "1/mm", "relative", ...
  /// Standard deviation of the values in `file`, in their units; float.
  std::optional<std::filesystem::path> deviation = std::nullopt;
};

/// An image of the history's size that belongs to something.
struct HistoryImage {
  std::string name;
  std::filesystem::path file;  ///< Relative to the history.
};

struct HistoryFrame {
  double time = 0.0;           ///< In the history's time unit; strictly increasing.
  std::filesystem::path file;  ///< Half RGB EXR, linear albedo; relative to the history.
  /// 8 bit; 0 where this frame's color is not the surface's (highlight, saturated, out of the stabilized view).
  std::optional<std::filesystem::path> mask = std::nullopt;
  /// In the order of kFrameExtraNames, each at most once; float.
  std::vector<HistoryImage> extras = {};
  bool is_extrapolated = false;  ///< Nobody saw it: a model continues from where the frames end.
  /// Simulations only: the amount of each material on every texel, one channel per material; float.
  std::optional<std::filesystem::path> amounts = std::nullopt;
};

using HistoryMap = HistoryImage;  ///< One of kHistoryMapNames.

/// What `history.json` says.
struct HistoryManifest {
  std::string name;
  std::string origin = "captured";  ///< captured | simulated | synthetic
  int width = 0;
  int height = 0;
  std::optional<double> texel_size_mm;
  TimeUnit time_unit = TimeUnit::Seconds;
  std::vector<HistoryFrame> frames;
  std::vector<ControlParameter> controls;
  std::optional<std::filesystem::path> mask;
  std::vector<HistoryMap> maps;  ///< In the order of kHistoryMapNames.
  std::string key;
  std::vector<LibraryPart> parts = {};        ///< Of a library.
  std::vector<HistoryWarning> warnings = {};  ///< The worst first.
  std::vector<SampleFact> sample = {};
};
/// The facts of a history without its files.
[[nodiscard]] HistoryFacts facts_of(const HistoryManifest& manifest);

/// Reads a history frame by frame; memory does not grow with the number of frames.
class HistoryReader final : public History {
 public:
  /// Opens a folder (or its history.json) and checks that every file is there and has the right size; pixels are
  /// decoded later.
  /// @param footprint_px  Pixels along the side of what a texel that shows this history covers: above 1.25 frames, and
  /// what they have beside color, are means over so much of the surface (inside the mask). Controls stay as they are.
  /// @throws IoError naming the file.
  explicit HistoryReader(const std::filesystem::path& path, double footprint_px = 1.0);

  [[nodiscard]] const HistoryFacts& facts() const override { return facts_; }
  [[nodiscard]] const std::string& label() const override { return label_; }
  [[nodiscard]] const HistoryManifest& manifest() const { return manifest_; }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  [[nodiscard]] ImageF load_frame(std::size_t frame) const override;
  [[nodiscard]] ImageF load_control(std::size_t control) const override;
  [[nodiscard]] ImageF load_control_deviation(std::size_t control) const override;
  [[nodiscard]] ImageU8 load_mask() const override;
  [[nodiscard]] ImageF load_map(std::size_t map) const override;
  [[nodiscard]] ImageF load_frame_extra(std::size_t frame, std::size_t extra) const override;
  [[nodiscard]] ImageU8 load_frame_mask(std::size_t frame) const override;
  [[nodiscard]] ImageF checked_material(const HistoryImage& image, ImageF values) const;

  std::filesystem::path folder_;
  std::string label_;
  double footprint_px_;
  HistoryManifest manifest_;
  HistoryFacts facts_;
};

/// Writes a history into an existing folder, frame by frame, and the manifest last. Not thread-safe; the static
/// functions are.
class HistoryWriter {
 public:
  /// @param manifest  name, origin, size, texel_size_mm, time_unit and key; lists may be empty.
  /// @throws InvalidInput if a size is outside [1, 65536] or the origin is unknown.
  HistoryWriter(std::filesystem::path folder, HistoryManifest manifest);
  /// The file name, relative to the history, that frame `index` gets: frames/0007.exr.
  [[nodiscard]] static std::filesystem::path frame_file(int index);
  /// masks/0007.png: where frame `index` is valid.
  [[nodiscard]] static std::filesystem::path frame_mask_file(int index);
  /// filled/0007.exr: frame `index` with what its mask leaves out filled from other times.
  [[nodiscard]] static std::filesystem::path filled_frame_file(int index);
  /// controls/<name>.exr. @param name  [A-Za-z0-9._-]+, not starting with a dot; @throws InvalidInput.
  [[nodiscard]] static std::filesystem::path control_file(const std::string& name);
  [[nodiscard]] static std::filesystem::path mask_file() { return "mask.png"; }
  /// maps/<name>.exr. @throws InvalidInput unless a HistoryMap may have the name.
  [[nodiscard]] static std::filesystem::path map_file(const std::string& name);

  /// @param values  H x W x 1, physical; normalized to [0, 1] by [low, high] and clamped when written (float).
  /// @param low,high  finite, low <= high; when equal, 0 is written everywhere.
  void write_control(const std::string& name, const ImageF& values, double low, double high, const std::string& unit);
  /// controls/<name>.stddev.exr.
  [[nodiscard]] static std::filesystem::path control_deviation_file(const std::string& name);
  /// Standard deviation of the control that was named last, which write_control() has written. @param values  H x W x
  /// 1, in the units of its values, >= 0; kept over (high - low), as the control is. @throws InvalidInput on another
  /// size, values below 0, or without a control.
  void write_control_deviation(const ImageF& values);
  /// Names a control that an earlier step has written already, as control_file(control.name).
  void add_written_control(const ControlParameter& control);
  /// @param rgb  H x W x 3, linear, finite, at most 65504.
  void write_frame(int index, double time, const ImageF& rgb);
  /// Names a frame that an earlier, interrupted run has written already.
  void add_written_frame(int index, double time);
  /// Names the mask of a frame that is named already, which an earlier step has written as frame_mask_file(index).
  /// @throws InvalidInput if frame `index` is not there.
  void add_written_frame_mask(int index);
  /// stddev/0007.exr and so on. @throws InvalidInput unless the name is of kFrameExtraNames.
  [[nodiscard]] static std::filesystem::path frame_extra_file(int index, const std::string& name);
  /// Writes frame_extra_file(); static, since steps that know no writer make it. @throws InvalidInput on other
  /// channels.
  static void write_frame_extra(const std::filesystem::path& folder, int index, const std::string& name,
                                const ImageF& values);
  /// Names what write_frame_extra() has written for a frame that is named already. @throws InvalidInput if frame
  /// `index` is not there.
  void add_written_frame_extra(int index, const std::string& name);
  /// amounts/0007.exr.
  [[nodiscard]] static std::filesystem::path frame_amounts_file(int index);
  /// Writes it. @param materials  Names of the channels, different. @param values  H x W x materials, >= 0.
  static void write_frame_amounts(const std::filesystem::path& folder, int index,
                                  const std::vector<std::string>& materials, const ImageF& values);
  /// Names what write_frame_amounts() has written for a frame that is named already. @throws InvalidInput if frame
  /// `index` is not there.
  void add_written_frame_amounts(int index);
  /// Lets a frame that is named already show filled_frame_file(index), which an earlier step has written. Its mask
  /// stays.
  /// @throws InvalidInput if frame `index` is not there.
  void add_filled_frame(int index);
  /// @param mask  H x W; not 0 = inside. @throws InvalidInput if it covers nothing.
  void write_mask(const ImageU8& mask);
  /// Names the mask that an earlier step has written already, as mask_file().
  void add_written_mask();
  /// Writes map_file(name); static, since steps that know no writer make maps. @param values  Of the history's size,
  /// with the channels of the map. @throws InvalidInput
  static void write_map(const std::filesystem::path& folder, const std::string& name, const ImageF& values);
  /// Names a map that an earlier step has written already, as map_file(name). @throws InvalidInput if it is named
  /// already.
  void add_written_map(const std::string& name);
  /// @throws InvalidInput unless finite and > 0.
  void set_texel_size_mm(double size);
  /// In any order: finish() puts the worst first.
  void add_warning(HistoryWarning warning);
  /// Sorts frames by time, warnings by weight, and writes history.json. @throws InvalidInput if there is no frame,
  /// times are equal or not finite, or two controls share a name; CannotComplete if it cannot be written.
  void finish();
  [[nodiscard]] const HistoryManifest& manifest() const { return manifest_; }

 private:
  HistoryFrame& named_frame(int index);

  std::filesystem::path folder_;
  HistoryManifest manifest_;
};

/// The file in a history's folder that says what is in it.
inline constexpr const char* kHistoryManifestFile = "history.json";
/// `history.json` of a folder, or the file itself. Other files are not looked at.
/// @throws IoError if it breaks the format: unknown key, wrong type, times not strictly increasing, parts that do not
/// fit, ...
[[nodiscard]] HistoryManifest read_history_manifest(const std::filesystem::path& path);
/// Equal manifests give equal bytes. @throws InvalidInput as HistoryWriter::finish; CannotComplete.
void write_history_manifest(const std::filesystem::path& file, const HistoryManifest& manifest);

}  // namespace patinate
