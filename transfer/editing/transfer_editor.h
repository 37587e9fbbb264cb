/// \file
/// A finished transfer that is edited: controls are painted, and the coordinates follow where the brush was.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/run_control.h"
#include "patinate/transfer/transfer_reader.h"
#include "transfer/files/transfer_edits.h"
#include "transfer/synthesis/region_synthesis.h"

namespace patinate::transfer {

/// Edits begin with what the folder of a transfer holds, and each with what those before have left: a list of edits
/// gives the same coordinates whether it is applied at once or one by one, and in every program.
class TransferEditor {
 public:
  /// Opens a transfer folder, or its transfer.json; one that was edited before goes on from there.
  /// @param appearance  As TransferInput's, of the history that the folder names.
  /// @throws IoError; InvalidInput if it was made by --method reference, or looks at whole pixels only; Canceled
  explicit TransferEditor(const std::filesystem::path& path, const AppearanceSource& appearance = {},
                          const RunControl& control = {});
  ~TransferEditor();
  TransferEditor(const TransferEditor&) = delete;
  TransferEditor& operator=(const TransferEditor&) = delete;

  [[nodiscard]] const TransferReader& reader() const { return *reader_; }
  [[nodiscard]] const TexelMap& map() const { return *map_; }
  /// Whether the history has structure, or all borders are refined: EditKind::Refine does something.
  [[nodiscard]] bool has_structure() const;
  /// Something was painted since the last refinement.
  [[nodiscard]] bool can_refine() const { return is_painted_since_; }

  /// Texels outside of what is returned keep their coordinates. @returns those under the brush and around, ascending.
  /// @throws InvalidInput if the edit reaches no texel, or names a control that is not followed; Canceled, and then
  /// nothing has changed
  std::span<const TexelId> apply(const TransferEdit& edit, const RunControl& control = {});
  /// The last edit that is applied, as if it had not been. @returns its texels; none if there is no such edit.
  std::span<const TexelId> undo();
  /// The last one undone, again.
  std::span<const TexelId> redo();
  [[nodiscard]] std::size_t num_undoable() const { return num_applied_ - num_forgotten_; }
  [[nodiscard]] std::size_t num_redoable() const;

  /// The edits that are applied. Those that the folder had come first.
  [[nodiscard]] TransferEdits edits() const;
  /// Of the history, at its full size.
  [[nodiscard]] SourcePlace place(TexelId t) const;
  /// What a control asks for, [0, 1] in the history's values. @param control  As the transfer's.
  [[nodiscard]] double wanted(std::size_t control, TexelId t) const;
  /// Writes coordinates, energy and edits into the folder of the transfer that was opened.
  void write(const RunControl& control = {}) const;

 private:
  struct Saved;
  /// An edit with what was there before it, or, once undone, after it.
  struct Step;
  [[nodiscard]] std::size_t control_index(const TransferEdit& edit) const;
  void save(std::span<const TexelId> texels, Saved& saved) const;
  std::span<const TexelId> swap(Step& step);
  [[nodiscard]] TexelSet painted_region(const RunControl& control) const;
  [[nodiscard]] std::vector<BrushedTexel> brushed_texels(const TransferEdit& edit, const RunControl& control) const;
  void paint(const TransferEdit& edit, std::span<const BrushedTexel> texels);
  void look_back();
  void forget_old_steps();

  std::shared_ptr<const TransferReader> reader_;
  std::shared_ptr<const HistoryReader> history_;  ///< Its own pixels, no means over footprints.
  std::shared_ptr<const TexelMap> map_;
  TransferEdits earlier_;  ///< Of the folder.
  std::vector<std::string> controls_;
  std::unique_ptr<RegionSynthesis> synthesis_;
  std::unique_ptr<SurfaceBrush> brush_;
  std::vector<Step> steps_;
  std::size_t num_applied_ = 0, num_forgotten_ = 0;
  bool is_painted_since_ = false;
};

}  // namespace patinate::transfer
